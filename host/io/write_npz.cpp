// writeNpz() writes a matrix for scipy.sparse.load_npz: the arrays of its compressed rows, with format and shape.
#include "io/entry_rows.h"
#include "io/npz_file.h"
#include "io/writers.h"

namespace viewpeel {

void writeNpz(const FormFactors& form_factors, std::ostream& out) {
  const EntryRows entries(form_factors);
  const std::vector<uint32_t> rows = form_factors.ids().rows();
  const std::vector<int64_t> starts = entries.startsOfRows();
  const auto count = static_cast<size_t>(starts.back());
  const std::vector<int64_t> shape(2, static_cast<int64_t>(starts.size()) - 1);
  NpzOutput file(out);
  file.write<int32_t>("indices", count, [&](const auto& use) {
    makeColumn<int32_t>(
        entries, [&](const RowEntry& entry) { return rows[entry.j]; }, use);
  });
  file.write<int64_t>("indptr", starts);
  file.writeText("format", "csr");
  file.write<int64_t>("shape", shape);
  file.write<double>("data", count, [&](const auto& use) {
    makeColumn<double>(
        entries, [](const RowEntry& entry) { return entry.form_factor.value; }, use);
  });
  file.finish();
}

}  // namespace viewpeel
