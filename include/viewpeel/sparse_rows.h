// Compresses form factors to sparse rows, as SciPy, AnnData and View3D's sparse layout have them.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// SparseRows are rows of the file, empty ones too, counted from 0. The entries of row i are from starts[i] to
// starts[i + 1]. Columns ascend within a row; environment and leak are left out.
struct SparseRows {
  std::vector<int64_t> starts;   // rows + 1
  std::vector<int32_t> columns;  // nonzeros
  std::vector<double> form_factors, standard_errors;
  std::vector<double> lower, upper;  // of a guarantee; else empty

  int64_t rowCount() const { return static_cast<int64_t>(starts.size()) - 1; }
};

// Compresses F_ij = A_i F_ij / A_i of the requested rows, both ways.
//   In: form_factors: n rows    Out: the nonzero entries
//   Error: one rounding. Tests: tests/files/output_files_test.cpp.
//   Throws: Error limit beyond 2^31 - 1 rows.
//   Cost: O(nonzeros) work and memory.
SparseRows compressRows(const FormFactors& form_factors);

// Spreads a value of each id over the rows of the file; empty rows have 0.    Cost: O(rows).
std::vector<double> spreadOverRows(const Ids& ids, const std::vector<double>& of_ids);

// Returns the names of all rows of the file, empty ones too.    Cost: O(rows).
std::vector<std::string> rowNames(const Ids& ids);

}  // namespace viewpeel
