// readResult() reads the results that an earlier run has written.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A StoredResult is all that a .h5 of results says about form factors.
struct StoredResult {
  FormFactors form_factors;                // Ids::of_polygon is empty: the file does not list polygons by id
  std::optional<FormFactors> balanced;     // balanced form factors, where the file has them
  std::vector<std::string> surface_names;  // names that Ids::surface is an index of
  // Each is a name and a value as text: OutputContent::parameters, so that the result can be written again.
  std::vector<std::pair<std::string, std::string>> parameters;
};

// Reads form factors from a .h5 that writeFormFactors or the program has written.
//   In: file: .h5    Out: the rows, entries, standard errors and intervals that were written
//   Error: an exchange area is A_i times the stored F_ij, with one rounding. Dividing by A_i again adds another one.
//     Tests: tests/files/read_result_test.cpp.
//   Throws: Error bad_input, naming the file and the remedy, where the file is no .h5 of results, cut off or damaged.
//   Cost: O(nonzeros log nonzeros) work, O(nonzeros) memory.
StoredResult readResult(const std::filesystem::path& file);

}  // namespace viewpeel
