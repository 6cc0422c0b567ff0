// writeNpz() writes a matrix for scipy.sparse.load_npz: the arrays of its compressed rows, with format and shape.
#include "io/entry_rows.h"
#include "io/npz_file.h"
#include "io/writers.h"

namespace viewpeel {

void writeNpz(const FormFactors& form_factors, std::ostream& out) {
  const EntryRows entries(form_factors);
  const std::vector<uint32_t> rows = form_factors.ids().rows();
  const auto forEachPair = [&](const auto& use) {
    entries.forEach([&](const RowEntry& entry) {
      if (entry.j < kEnvironment) use(entry);
    });
  };
  const std::vector<int64_t> starts = entries.startsOfRows();
  const auto count = static_cast<size_t>(starts.back());
  const std::vector<int64_t> shape(2, static_cast<int64_t>(starts.size()) - 1);
  NpzOutput file(out);
  file.write<int32_t>("indices", count, [&](const auto& use) {
    forEachPair([&](const RowEntry& entry) { use(static_cast<int32_t>(rows[entry.j])); });
  });
  file.write<int64_t>("indptr", starts);
  file.writeText("format", "csr");
  file.write<int64_t>("shape", shape);
  file.write<double>("data", count, [&](const auto& use) {
    forEachPair([&](const RowEntry& entry) { use(entry.form_factor.value); });
  });
  file.finish();
}

}  // namespace viewpeel
