// Who may replace a file that many processes see.
#pragma once
#include <filesystem>

namespace viewpeel {

// A FileLock locks a file as it is now: one process has it, until it ends or lets go. A file put in its place is
// another file.
class FileLock {
 public:
  FileLock() = default;
  ~FileLock() { release(); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  // Locks the file; returns false where another process has it, or the file cannot be opened. Lets go of the file that
  // was locked before.
  //   Source: flock(2), which is released by the kernel however the process ends.
  bool take(const std::filesystem::path& file);
  // Returns whether the locked file is the one of that name.
  bool isOn(const std::filesystem::path& file) const;
  void release();

 private:
  int opened_ = -1;
};

}  // namespace viewpeel
