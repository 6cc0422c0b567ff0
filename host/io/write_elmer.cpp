// writeElmer() writes Elmer's ViewFactors.dat: text for Fortran's list-directed READ, or a stream of bytes.
//   Source: Elmer 9, RadiationFactors.F90, ReadViewFactorsFromFile.
#include <fmt/ostream.h>

#include <viewpeel/sparse_rows.h>
#include "io/put_bytes.h"
#include "io/writers.h"

namespace viewpeel {

void writeElmer(const FormFactors& form_factors, bool is_binary, std::ostream& out) {
  const SparseRows rows = compressRows(form_factors);
  if (is_binary) putBytes(out, static_cast<int32_t>(rows.rowCount()));
  for (int64_t i = 0; i < rows.rowCount(); ++i) {
    const int64_t count = rows.starts[i + 1] - rows.starts[i];
    if (is_binary) putBytes(out, static_cast<int32_t>(count));
    else fmt::print(out, "{}\n", count);
    for (int64_t k = rows.starts[i]; k < rows.starts[i + 1]; ++k) {
      if (!is_binary) {
        fmt::print(out, "{} {} {}\n", i + 1, rows.columns[k] + 1, rows.form_factors[k]);
        continue;
      }
      putBytes(out, rows.columns[k] + 1);
      putBytes(out, rows.form_factors[k]);
    }
  }
}

}  // namespace viewpeel
