// A .h5 is read back for its page.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "report/report_content.h"

namespace viewpeel {

// Reads a .h5 of writeFormFactors, with or without a geometry.
//   Out: numbers to the last bit; balanced form factors are left out
//   Throws: Error bad_input, naming the file: not a .h5 of viewpeel, cut off, damaged, or with columns that do
//     not fit each other.
//   Cost: the file in memory.
ReportContent readReport(const std::filesystem::path& file);
// Reads the same from memory.    In: name: for messages
ReportContent readReport(const std::vector<char>& bytes, const std::string& name);

}  // namespace viewpeel
