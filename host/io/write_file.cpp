#include "io/write_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "error.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::output, fmt::format("{}: cannot write: {}; choose another place with -o", file.string(), reason));
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
    std::error_code failure;
    fs::rename(temporary, file, failure);
    if (failure) refuse(file, failure.message());
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
}

void checkWritable(const fs::path& file) {
  if (fs::is_directory(file)) refuse(file, "it is a directory");
  const fs::path temporary = temporaryName(file);
  errno = 0;
  const bool opened = std::ofstream(temporary).is_open();
  const int reason = errno;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  if (!opened) refuse(file, std::strerror(reason));
}

}  // namespace viewpeel
