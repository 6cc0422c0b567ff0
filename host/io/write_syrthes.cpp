// writeSyrthes() writes SYRTHES's mesh.fdf: exchange areas of a run on one rank.
//   Source: SYRTHES 4.3.5, its own files.
#include <viewpeel/sparse_rows.h>
#include "io/put_bytes.h"
#include "io/writers.h"

namespace viewpeel {

// Writes the file. A row's diagonal is its area less its other entries and environment, as in SYRTHES's files.
void writeSyrthes(const FormFactors& form_factors, std::ostream& out) {
  const SparseRows rows = compressRows(form_factors);
  const Ids& ids = form_factors.ids();
  const std::vector<double> areas = spreadOverRows(ids, ids.areas);
  std::vector<double> of_ids(ids.count());
  for (uint32_t id = 0; id < ids.count(); ++id) of_ids[id] = form_factors.formFactor(id, kEnvironment).value;
  const std::vector<double> environment = spreadOverRows(ids, of_ids);
  const int64_t n = rows.rowCount();
  std::vector<double> diagonal(static_cast<size_t>(n));
  std::vector<int32_t> counts(static_cast<size_t>(n), 0);
  for (int64_t i = 0; i < n; ++i) {
    double rest = 1 - environment[i];
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k) {
      if (rows.columns[k] == i) continue;
      rest -= rows.form_factors[k];
      ++counts[i];
    }
    diagonal[i] = areas[i] * rest;
  }
  putBytes(out, static_cast<int32_t>(n));
  for (double value : diagonal) putBytes(out, value);
  for (int32_t count : counts) putBytes(out, count);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k)
      if (rows.columns[k] != i) putBytes(out, rows.columns[k]);
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k)
      if (rows.columns[k] != i) putBytes(out, areas[i] * rows.form_factors[k]);
  }
}

}  // namespace viewpeel
