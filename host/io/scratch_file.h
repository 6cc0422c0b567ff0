// A ScratchFile keeps lists on disk that memory has no room for.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace viewpeel {

// A ScratchFile is a file without a name in its folder, so that the system removes it when the process ends.
class ScratchFile {
 public:
  // A Place has one list. It moves to the end of the file where the list outgrows its room.
  struct Place {
    uint64_t first = 0, room = 0;  // bytes
    size_t count = 0;              // entries
  };

  //   In: beside: a path; the scratch file is made in the folder of this path
  //   Throws: Error output where nothing can be written to the folder.
  explicit ScratchFile(const std::filesystem::path& beside);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  // Write a list to its place, and read it from there.
  //   Throws: Error output, with the folder and the system's reason.
  template <class T>
  void write(Place& place, const std::vector<T>& list) {
    static_assert(std::is_trivially_copyable_v<T>);
    makeRoom(place, list.size() * sizeof(T));
    place.count = list.size();
    writeBytes(place.first, list.data(), list.size() * sizeof(T));
  }
  template <class T>
  std::vector<T> read(const Place& place) const {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> list(place.count);
    readBytes(place.first, list.data(), list.size() * sizeof(T));
    return list;
  }

 private:
  [[noreturn]] void fail(const char* what) const;
  void makeRoom(Place& place, size_t size);
  void writeBytes(uint64_t place, const void* bytes, size_t size) const;
  void readBytes(uint64_t place, void* bytes, size_t size) const;

  std::string folder_;
  int file_ = -1;
  uint64_t end_ = 0;  // of all places
};

}  // namespace viewpeel
