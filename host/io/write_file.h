// Files written here are at any time whole or untouched.
#pragma once
#include <filesystem>
#include <functional>
#include <ostream>

namespace viewpeel {

// Writes to a temporary file in the same folder, waits until the disk has the bytes, and gives it the name `file`. So
// `file` is at any time, after a power cut too, either whole or untouched.
//   A file that was there keeps its mode and, where the system allows it, its owner. A symbolic link stays, and the
//     file that it names is replaced. If the program is killed meanwhile the temporary file stays: FILE, 16
//     hexadecimal digits, and .part.
//   Throws: Error output, naming the file and the system's reason.
void writeFile(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

// Finds before a long computation that writeFile could not work: missing folder, a directory in the way, no permission,
// a full disk.
//   Throws: Error bad_usage, naming the file and the system's reason.
void checkWritable(const std::filesystem::path& file);

}  // namespace viewpeel
