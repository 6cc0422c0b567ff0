// This header reads the files that io/hdf5_output.h describes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/hdf5_silence.h"

namespace viewpeel {

// An Hdf5Input reads a file that an Hdf5Output has made.
class Hdf5Input {
 public:
  // Opens a file.
  //   In: kind: what messages call the file; remedy: what they advise where it cannot be used
  //   Throws: Error bad_input where there is no such file, or its check sum is wrong.
  explicit Hdf5Input(const std::filesystem::path& file, const char* kind = "checkpoint",
                     const char* remedy = "take another, or remove it and start afresh");
  // Opens a file in memory, the bytes that Hdf5Output::finish returned.    In: name: for messages
  Hdf5Input(const std::vector<char>& bytes, const std::string& name, const char* kind, const char* remedy);
  ~Hdf5Input();
  Hdf5Input(const Hdf5Input&) = delete;

  // Reads a column.    In: count: the number of values that it must have, where known
  //   Throws: Error bad_input where there is no such column of this type and length.
  template <class T>
  std::vector<T> read(const std::string& name, std::optional<size_t> count = {});
  // Reads a column written by writeTexts.    Throws: Error bad_input where there is no such column.
  std::vector<std::string> readTexts(const std::string& name);
  // Returns the attributes of the file as texts; numbers in the shortest form that reads back to the same number.
  std::vector<std::pair<std::string, std::string>> attributes();
  // Returns whether there is this column or group.    In: name: its group must exist
  bool has(const std::string& name) const;
  [[noreturn]] void refuse(const std::string& reason) const;

 private:
  Hdf5Silence silence_;
  std::filesystem::path file_;
  const char *kind_, *remedy_;
  uint64_t size_bytes_ = 0;
  int64_t id_ = -1;
};

}  // namespace viewpeel
