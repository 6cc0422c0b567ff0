// In fuzz targets of .h5 files the input decides, column by column, which values are stored. HDF5 itself always gets
// sound files, for it may crash on damaged ones, which the check sum normally keeps out (host/io/hdf5_output.h).
#pragma once
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "io/hdf5_output.h"

namespace viewpeel::fuzz {

// Bytes reads the input from front to back, and returns zeros after its end.
class Bytes {
 public:
  Bytes(const uint8_t* bytes, size_t count) : at_(bytes), end_(bytes + count) {}
  template <class T>
  T take() {
    T value{};
    const size_t count = std::min(sizeof value, static_cast<size_t>(end_ - at_));
    if (count) std::memcpy(&value, at_, count);
    at_ += count;
    return value;
  }
  template <class T>
  std::vector<T> takeColumn() {
    std::vector<T> column(take<uint8_t>() % 8);
    for (T& value : column) value = take<T>();
    return column;
  }
  std::vector<std::string> takeTexts() {
    std::vector<std::string> column(take<uint8_t>() % 8);
    for (std::string& text : column)
      for (uint8_t left = take<uint8_t>() % 16; left > 0; --left) text += take<char>();
    return column;
  }

 private:
  const uint8_t *at_, *end_;
};

// Writes the correct column where no input is left. Otherwise it may write another column, or none.
template <class T>
void writeColumn(Hdf5Output& out, Bytes& bytes, const std::string& name, const std::vector<T>& whole) {
  switch (bytes.take<uint8_t>() % 9) {
    case 0:
      return out.write(name, whole);
    case 1:
      return out.write(name, bytes.takeColumn<uint8_t>());
    case 2:
      return out.write(name, bytes.takeColumn<uint32_t>());
    case 3:
      return out.write(name, bytes.takeColumn<uint64_t>());
    case 4:
      return out.write(name, bytes.takeColumn<double>());
    case 5:
      return out.write(name, bytes.takeTexts());
    case 6:
      return;  // the column is missing
    case 7:
      return out.write(name, bytes.takeColumn<int32_t>());
    default:
      return out.write(name, bytes.takeColumn<int64_t>());
  }
}

// NamedFile has a name in the file system, for HDF5 cannot open a file without one. Every call uses the same name.
class NamedFile {
 public:
  explicit NamedFile(const char* kind)
      : path_(std::filesystem::temp_directory_path() / fmt::format("fuzz_{}.{}", kind, ::getpid())) {}
  ~NamedFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& write(const std::vector<char>& bytes) const {
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace viewpeel::fuzz
