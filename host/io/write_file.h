// writeFile() replaces a file in one step, so that readers never see half a file.
#pragma once
#include <filesystem>
#include <functional>
#include <ostream>

namespace viewpeel {

class FileLock;

// Writes to a temporary file in the same folder, waits until the disk has the bytes, and renames it to `file`. So
// `file` is whole or untouched at any time, even after a power cut.
//   In: lock: this process's lock of the old file; nullptr: none. The new file is locked before it has its name, and
//     the old file is released after that. So no other process can lock the file of this name meanwhile.
//   A file that existed keeps its mode and, where the system allows it, its owner. A symbolic link stays, and its
//     target is replaced. A program that is killed meanwhile leaves the temporary file: FILE, 16 hexadecimal digits,
//     and .part.
//   Throws: Error output, naming the file and the system's reason.
void writeFile(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write,
               FileLock* lock = nullptr);

// Writes a file as writeFile does, for a function that opens the temporary file itself, by its name.
void writeFileByName(const std::filesystem::path& file, const std::function<void(const std::string& name)>& write);

// Checks before a long computation that writeFile would work: missing folder, a directory in the way, no permission, or
// a full disk.
//   Throws: Error bad_usage, naming the file and the system's reason.
void checkWritable(const std::filesystem::path& file);

}  // namespace viewpeel
