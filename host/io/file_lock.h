// A FileLock decides which of several processes may replace a file that all of them see.
#pragma once
#include <filesystem>
#include <utility>

namespace viewpeel {

// A FileLock locks a file, not its name: one process has the lock until it ends or releases it. A file that is renamed
// to the same name is another file, without the lock.
class FileLock {
 public:
  FileLock() = default;
  ~FileLock() { release(); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  void swap(FileLock& other) { std::swap(opened_, other.opened_); }

  // Locks the file; returns false where another process has locked it, or it cannot be opened. Releases the file that
  // this object locked before.
  //   Source: flock(2), which is released by the kernel however the process ends.
  bool take(const std::filesystem::path& file);
  // Returns whether the locked file is still the one of this name.
  bool isOn(const std::filesystem::path& file) const;
  void release();

 private:
  int opened_ = -1;
};

}  // namespace viewpeel
