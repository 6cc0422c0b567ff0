// Results are read back from a file.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A StoredResult is all that a .h5 of results says of form factors.
struct StoredResult {
  FormFactors form_factors;                // its ids know no polygons: Ids::of_polygon is empty
  std::optional<FormFactors> balanced;     // balanced form factors, where the file has them
  std::vector<std::string> surface_names;  // of the indices in Ids::surface
  // Each is a name and a value, in words: OutputContent::parameters, and closure.
  std::vector<std::pair<std::string, std::string>> parameters;
};

// Reads form factors from a .h5 that writeFormFactors or the program has written.
//   In: file: .h5    Out: the rows, entries, standard errors and intervals that were written
//   Error: an exchange area is A_i times the F_ij stored: one rounding, another where it is divided by A_i again.
//     Tests: tests/files/read_result_test.cpp.
//   Throws: Error bad_input, naming the file and the remedy, where it is no .h5 of results, cut off or damaged.
//   Cost: O(nonzeros log nonzeros) work, O(nonzeros) memory.
StoredResult readResult(const std::filesystem::path& file);

}  // namespace viewpeel
