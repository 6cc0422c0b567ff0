#include "io/write_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBlockBytes = 4096;  // of a file system

[[noreturn]] void refuse(const fs::path& file, const std::string& reason, ErrorCode code = ErrorCode::output) {
  throw Error(code, fmt::format("{}: cannot write: {}; choose another place", file.string(), reason));
}

// Waits until the disk has the bytes of the file, or the names in the folder. Returns errno. File systems that cannot
// wait say EINVAL, folders that may be written but not read EACCES: then no more can be done.
int waitForDisk(const fs::path& file) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const int number = opened >= 0 && ::fsync(opened) == 0 ? 0 : errno;
  if (opened >= 0) ::close(opened);
  return number == EINVAL || number == EACCES ? 0 : number;
}

fs::path temporaryName(const fs::path& file) { return file.string() + fmt::format(".{}.part", ::getpid()); }

}  // namespace

void writeFile(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  const fs::path temporary = temporaryName(file);
  std::error_code ignored;
  try {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    if (!out) refuse(file, std::strerror(errno));
    write(out);
    out.close();
    if (!out) refuse(file, errno ? std::strerror(errno) : "the disk is full");
    if (const int number = waitForDisk(temporary)) refuse(file, std::strerror(number));
    std::error_code failure;
    fs::rename(temporary, file, failure);
    if (failure) refuse(file, failure.message());
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
  if (const int number = waitForDisk(file.has_parent_path() ? file.parent_path() : "."))
    refuse(file, std::strerror(number));
}

void checkWritable(const fs::path& file) {
  std::error_code failure;
  const fs::file_status status = fs::status(file, failure);
  if (fs::is_directory(status)) refuse(file, "it is a directory", ErrorCode::bad_usage);
  if (fs::exists(status) && !fs::is_regular_file(status))
    refuse(file, "it is not a regular file", ErrorCode::bad_usage);
  const fs::path temporary = temporaryName(file);
  errno = 0;
  std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
  // A full disk takes empty files.
  out << std::string(kBlockBytes, ' ');
  out.close();
  const int reason = errno;
  fs::remove(temporary, failure);
  if (!out) refuse(file, reason ? std::strerror(reason) : "the disk is full", ErrorCode::bad_usage);
}

}  // namespace viewpeel
