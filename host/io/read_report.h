// readReport() reads a .h5 of results for the page that shows it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "report/report_content.h"

namespace viewpeel {

// Reads a .h5 of writeFormFactors, with or without a geometry.
//   Out: numbers to the last bit; balanced form factors are left out
//   Throws: Error bad_input, naming the file, where it is no .h5 of viewpeel, cut off or damaged, or where its columns
//     do not match each other.
//   Cost: the whole file is in memory.
ReportContent readReport(const std::filesystem::path& file);
// Reads the same from memory.    In: name: for messages
ReportContent readReport(const std::vector<char>& bytes, const std::string& name);

}  // namespace viewpeel
