#pragma once
#include <filesystem>
#include <ostream>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// Comma-separated: header `from,to,form_factor,standard_error`, then one nonzero entry a line, both ways; `environment` and `leak` stand
// in `to`. Numbers in the shortest form that reads back to the same double; names quoted as in RFC 4180 where they must be.
//   In: closed, where there is closure: the same entries closed, for a further column `closed_form_factor`
void writeCsv(const FormFactors& form_factors, std::ostream& out, const FormFactors* closed = nullptr);

// Matrix Market, coordinate real general: entry (i, j) is F_ij, rows and columns counted from 1; comment lines give every row's
// emitting area, environment share and name. Rows are in the order of the file, and its empty rows are among them.
//   In: what, for the first comment line
void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out, const char* what = "form factors");

// By the file's extension: .csv, or .mtx. With closure, .csv has a column more; .mtx stays as it is, and NAME.closed.mtx beside it has the closed
// form factors. Each file is atomic, see writeFile.
//   Throws: Error output.
void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file, const FormFactors* closed = nullptr);

// The files that writeFormFactors writes.
std::vector<std::filesystem::path> filesOf(const std::filesystem::path& file, bool with_closure);

// Refuses what writeFormFactors would refuse, before anything is computed.
//   Throws: Error bad_usage: an unknown extension, a name that closure takes, what cannot be written.
void checkOutput(const std::filesystem::path& file, bool with_closure = false);

}  // namespace viewpeel
