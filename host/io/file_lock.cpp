#include "io/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace viewpeel {

bool FileLock::take(const std::filesystem::path& file) {
  release();
  opened_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened_ < 0) return false;
  // A file system without locks cannot say who has the file.
  const bool locked = ::flock(opened_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  if (locked && isOn(file)) return true;
  release();
  return false;
}

bool FileLock::isOn(const std::filesystem::path& file) const {
  struct stat mine {
  }, there{};
  return opened_ >= 0 && ::fstat(opened_, &mine) == 0 && ::stat(file.c_str(), &there) == 0 &&
         mine.st_dev == there.st_dev && mine.st_ino == there.st_ino;
}

void FileLock::release() {
  if (opened_ >= 0) ::close(opened_);
  opened_ = -1;
}

}  // namespace viewpeel
