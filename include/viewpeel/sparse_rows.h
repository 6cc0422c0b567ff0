// compressRows() turns form factors into compressed sparse rows, the layout of SciPy, AnnData and View3D.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// SparseRows holds the rows of a file, counted from 0, with its empty rows. Row i has the entries from starts[i] to
// starts[i + 1] - 1, with ascending columns. Environment and leak are left out.
struct SparseRows {
  std::vector<int64_t> starts;   // rows + 1
  std::vector<int32_t> columns;  // nonzeros
  std::vector<double> form_factors, standard_errors;
  std::vector<double> lower, upper;  // intervals of a guarantee; empty for an estimate

  int64_t rowCount() const { return static_cast<int64_t>(starts.size()) - 1; }
};

// Returns F_ij and F_ji of every pair, in compressed rows. Rows that are not requested stay empty.
//   In: form_factors: of n rows    Out: the nonzero entries
//   Error: one rounding. Tests: tests/files/output_files_test.cpp.
//   Throws: Error limit beyond 2^31 - 1 rows.
//   Cost: O(nonzeros) work and memory.
SparseRows compressRows(const FormFactors& form_factors);

// Returns the value of each row of the file, from the value of each id. Empty rows get 0.    Cost: O(rows).
std::vector<double> spreadOverRows(const Ids& ids, const std::vector<double>& of_ids);

// Returns the name of each row of the file, with the empty rows.    Cost: O(rows).
std::vector<std::string> rowNames(const Ids& ids);

}  // namespace viewpeel
