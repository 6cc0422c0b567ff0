// Form factors are written to files: comma-separated, or in Matrix Market's format.
#pragma once
#include <filesystem>
#include <ostream>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Writes form factors comma-separated: header `from,to,form_factor,standard_error`, then one nonzero entry a line, both
// ways; `environment` and `leak` stand in `to`. Numbers have the shortest form that reads back to the same double.
// Names are quoted as in RFC 4180 where they must be.
// With intervals of a guarantee `lower` and `upper` are further columns.
//   In: form_factors: n rows; balanced: BalancedFormFactors::form_factors of these, for a further column
//     `balanced_form_factor`; nullptr: no such column
//   Out: 1 + (1 to 2) x nonzeros lines; form factors and standard errors without unit
//   Error: none: numbers read back to the same bits. Tests: tests/device/output_test.cpp.
//   Throws: nothing; a failure is out's state.
//   Cost: O(nonzeros).
void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* balanced = nullptr);

// Writes form factors in Matrix Market's format, coordinate real general: entry (i, j) is F_ij, rows and columns
// counted from 1. Comment lines give every row's emitting area, environment share and name. Rows are in the order of
// the file, and its empty rows are among them.
//   In: form_factors: n rows; what: for the first comment line
//   Out: an n x n matrix, without environment and leak, which are in the comments
//   Error, Throws, Cost: as writeCsv.
//   Source: R. F. Boisvert, R. Pozo & K. A. Remington, The Matrix Market exchange formats, NISTIR 5935, 1996.
void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what = "form factors");

// Writes a file by its extension, .csv or .mtx. With balanced form factors .csv has a column more; .mtx stays as it is,
// and NAME.balanced.mtx beside it has the balanced ones. A file is whole at any time, or untouched: it is written under
// another name and renamed.
//   In: as writeCsv; file: its folder exists    Out: the files of filesOf
//   Error: none. Tests: tests/device/output_test.cpp, tests/program/fault_test.cpp.
//   Throws: Error bad_usage for an unknown extension; Error output, naming file and the system's reason.
//   Cost: O(nonzeros).
void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file,
                      const FormFactors* balanced = nullptr);

// Returns the files that writeFormFactors writes: one, or two.    Throws: as writeFormFactors for the extension.
// Cost: O(1).
std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_balance);

// Refuses a file that writeFormFactors would refuse, before anything is computed.
//   Throws: Error bad_usage: an unknown extension, a name that --balance takes, a file that cannot be written.
//   Cost: one file of a byte, written and removed.
void checkOutput(const std::filesystem::path& file, bool with_balance = false);

}  // namespace viewpeel
