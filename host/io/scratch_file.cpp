#include "io/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint64_t kPage = 4096;

// Moves all bytes; a system call may move fewer at a time.    Out: false where it fails, errno says why
template <class Bytes>
bool moveAll(auto system_call, int file, uint64_t place, Bytes* bytes, size_t size) {
  for (size_t done = 0; done < size;) {
    errno = 0;
    const ssize_t moved = system_call(file, bytes + done, size - done, static_cast<off_t>(place + done));
    if (moved <= 0 && errno != EINTR) return false;
    if (moved > 0) done += static_cast<size_t>(moved);
  }
  return true;
}

}  // namespace

ScratchFile::ScratchFile(const std::filesystem::path& beside)
    : folder_(beside.has_parent_path() ? beside.parent_path().string() : std::string(".")) {
  std::string name = folder_ + "/viewpeel.XXXXXX";
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail("write");
  ::unlink(name.c_str());
}

ScratchFile::~ScratchFile() { ::close(file_); }

void ScratchFile::fail(const char* what) const {
  throw Error(ErrorCode::output, fmt::format("{}: cannot {} an unnamed file for blocks of rows: {}; write the output "
                                             "to a folder with more room",
                                             folder_, what, std::strerror(errno ? errno : ENOSPC)));
}

void ScratchFile::makeRoom(Place& place, size_t size) {
  if (size <= place.room) return;
  // The file has holes where nothing is written, so that twice the room takes no more of the disk. Where the file
  // system makes no holes, the old place is lost: all old places of a list are smaller than its present one.
  if (place.room)
    ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place.first),
                static_cast<off_t>(place.room));
  place.first = end_;
  place.room = (2 * size + kPage - 1) / kPage * kPage;
  end_ += place.room;
}

void ScratchFile::writeBytes(uint64_t place, const void* bytes, size_t size) const {
  if (!moveAll(::pwrite, file_, place, static_cast<const char*>(bytes), size)) fail("write");
}

void ScratchFile::readBytes(uint64_t place, void* bytes, size_t size) const {
  if (!moveAll(::pread, file_, place, static_cast<char*>(bytes), size)) fail("read");
}

}  // namespace viewpeel
