#pragma once
#include <filesystem>
#include <ostream>

#include "matrix/form_factors.h"

namespace viewpeel {

// Comma-separated: header `from,to,form_factor,standard_error`, then one nonzero entry a line, both ways; `environment` and `leak` stand
// in `to`. Numbers in the shortest form that reads back to the same double; names quoted as in RFC 4180 where they must be.
void writeCsv(const FormFactors& form_factors, std::ostream& out);

// Matrix Market, coordinate real general: entry (i, j) is F_ij, rows and columns counted from 1; comment lines give every row's
// emitting area, environment share and name.
void writeMatrixMarket(const FormFactors& form_factors, std::ostream& out);

// By the file's extension: .csv or .mtx. Atomic, see writeFile.
//   Throws: Error output.
void writeFormFactors(const FormFactors& form_factors, const std::filesystem::path& file);

// Refuses what writeFormFactors would refuse, before anything is computed.
//   Throws: Error bad_usage for an unknown extension, Error output.
void checkOutput(const std::filesystem::path& file);

}  // namespace viewpeel
