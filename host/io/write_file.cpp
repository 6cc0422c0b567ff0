#include "io/write_file.h"

#include <cerrno>
#include <cstring>
#include <random>
#include <string>

#include <ext/stdio_filebuf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include "io/file_lock.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFileSystemBlock = 4096;  // size of a block of a file system
constexpr mode_t kModeOfNewFiles = 0666, kModeOfOwner = 0600;

[[noreturn]] void refuse(const fs::path& file, const std::string& reason, ErrorCode code = ErrorCode::output) {
  throw Error(code, fmt::format("{}: cannot write: {}; choose another place", file.string(), reason));
}

// Waits until the disk has a file's bytes, or a folder's names. Returns errno. EINVAL means that the file system cannot
// wait, EACCES that a folder may be written and not read: both count as success.
int waitForDisk(const fs::path& file) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const int number = opened >= 0 && ::fsync(opened) == 0 ? 0 : errno;
  if (opened >= 0) ::close(opened);
  return number == EINVAL || number == EACCES ? 0 : number;
}

// Returns the file at the end of a chain of symbolic links, whether it exists or not; `file` where it is no link.
fs::path followLink(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  fs::path place = file;
  std::error_code failure;
  for (int k = 0; k < kMostLinks && fs::is_symlink(place, failure); ++k) {
    const fs::path target = fs::read_symlink(place, failure);
    if (failure) break;
    place = place.parent_path() / target;  // this is `target` itself where that path is absolute
  }
  return place;
}

// Returns 16 hexadecimal digits that nobody can predict.
std::string drawDigits() {
  std::random_device random;  // a source of the operating system
  return fmt::format("{:08x}{:08x}", random(), random());
}

// A TemporaryFile is a new file beside another, with a name that nobody can predict. It is removed unless it is renamed
// to the other's name. O_EXCL refuses a link that somebody else put in its place.
class TemporaryFile {
 public:
  // Throws: Error of this code, naming the other file.
  TemporaryFile(const fs::path& beside, ErrorCode code)
      : name_(fmt::format("{}.{}.part", beside.string(), drawDigits())) {
    struct stat old {};
    const bool replaces = ::stat(beside.c_str(), &old) == 0;
    // A new file gets the mode that the process gives new files. A file that replaces another is closed to all others
    // until it has the other's mode.
    const int opened =
        ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? kModeOfOwner : kModeOfNewFiles);
    if (opened < 0) refuse(beside, std::strerror(errno), code);
    // Only root may change the owner. Other users may at least keep the group if they belong to it.
    if (replaces && ::fchown(opened, old.st_uid, old.st_gid) != 0 && ::fchown(opened, uid_t(-1), old.st_gid) != 0)
      errno = 0;
    if (replaces) ::fchmod(opened, old.st_mode & 07777);
    buffer_ = __gnu_cxx::stdio_filebuf<char>(opened, std::ios::out | std::ios::binary);
  }
  ~TemporaryFile() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;

  // Writes into the file and closes it. Returns errno; 0 for success.
  int fill(const std::function<void(std::ostream&)>& write) {
    errno = 0;
    std::ostream out(&buffer_);
    write(out);
    const bool is_closed = buffer_.close() != nullptr;
    return out && is_closed ? 0 : errno ? errno : ENOSPC;
  }
  const std::string& name() const { return name_; }
  // Renames it to the other file's name. Returns errno; 0 for success.
  int rename(const fs::path& file) {
    if (::rename(name_.c_str(), file.c_str()) != 0) return errno;
    name_.clear();
    return 0;
  }

 private:
  std::string name_;
  __gnu_cxx::stdio_filebuf<char> buffer_;
};

// Gives a filled file its name, once the disk has its bytes.
void settle(TemporaryFile& temporary, const fs::path& file, const fs::path& named, FileLock* lock = nullptr) {
  if (const int number = waitForDisk(temporary.name())) refuse(named, std::strerror(number));
  FileLock next;
  if (lock) next.take(temporary.name());
  if (const int number = temporary.rename(file)) refuse(named, std::strerror(number));
  if (lock) lock->swap(next);
  if (const int number = waitForDisk(file.has_parent_path() ? file.parent_path() : "."))
    refuse(named, std::strerror(number));
}

}  // namespace

void writeFile(const fs::path& named, const std::function<void(std::ostream&)>& write, FileLock* lock) {
  const fs::path file = followLink(named);
  TemporaryFile temporary(file, ErrorCode::output);
  if (const int number = temporary.fill(write)) refuse(named, std::strerror(number));
  settle(temporary, file, named, lock);
}

void writeFileByName(const fs::path& named, const std::function<void(const std::string& name)>& write) {
  const fs::path file = followLink(named);
  TemporaryFile temporary(file, ErrorCode::output);
  write(temporary.name());
  if (const int number = temporary.fill([](std::ostream&) {})) refuse(named, std::strerror(number));
  settle(temporary, file, named);
}

void checkWritable(const fs::path& named) {
  const fs::path file = followLink(named);
  std::error_code failure;
  const fs::file_status status = fs::status(file, failure);
  if (fs::is_directory(status)) refuse(named, "it is a directory", ErrorCode::bad_usage);
  if (fs::exists(status) && !fs::is_regular_file(status))
    refuse(named, "it is not a regular file", ErrorCode::bad_usage);
  TemporaryFile temporary(file, ErrorCode::bad_usage);
  // An empty file would not show that the disk is full, so a block is written.
  const int number = temporary.fill([](std::ostream& out) { out << std::string(kFileSystemBlock, ' '); });
  if (number) refuse(named, std::strerror(number), ErrorCode::bad_usage);
}

}  // namespace viewpeel
