#pragma once
#include <filesystem>
#include <functional>
#include <ostream>

namespace viewpeel {

// Writes to a temporary name beside `file` and renames it, so that `file` is either whole or untouched.
//   Throws: Error output, naming the file and the system's reason.
void writeFile(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

// Finds before a long computation that writeFile could not work: missing folder, a directory in the way, no permission.
//   Throws: Error output.
void checkWritable(const std::filesystem::path& file);

}  // namespace viewpeel
