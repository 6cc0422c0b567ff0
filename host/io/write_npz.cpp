// writeNpz() writes a matrix for scipy.sparse.load_npz: the arrays of its compressed rows, with format and shape.
#include "io/npz_file.h"
#include <viewpeel/sparse_rows.h>
#include "io/writers.h"

namespace viewpeel {

void writeNpz(const FormFactors& form_factors, std::ostream& out) {
  const SparseRows rows = compressRows(form_factors);
  const std::vector<int64_t> shape(2, rows.rowCount());
  NpzOutput file(out);
  file.write<int32_t>("indices", rows.columns);
  file.write<int64_t>("indptr", rows.starts);
  file.writeText("format", "csr");
  file.write<int64_t>("shape", shape);
  file.write<double>("data", rows.form_factors);
  file.finish();
}

}  // namespace viewpeel
