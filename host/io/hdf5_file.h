// An HDF5 file here has flat columns, followed by a check sum of all bytes, 8 of them, little-endian. Readers of HDF5
// do not look there. A file that is cut off or damaged never gets to HDF5, which does not always survive it. Nor does
// it survive a full disk: files are made in memory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace viewpeel {

// Hdf5Silence switches HDF5's printing of errors off while it lives.
class Hdf5Silence {
 public:
  Hdf5Silence();
  ~Hdf5Silence();
  Hdf5Silence(const Hdf5Silence&) = delete;

 private:
  int (*print_)(int64_t, void*) = nullptr;
  void* print_data_ = nullptr;
};

// Makes a file in memory. Columns are of uint8_t, int32_t, uint32_t, int64_t, uint64_t, double or std::string (all as
// wide as the longest). The same columns make the same bytes.
class Hdf5Output {
 public:
  Hdf5Output();
  ~Hdf5Output();
  Hdf5Output(const Hdf5Output&) = delete;

  // In: name: with slashes for groups    Throws: Error limit where memory is short.
  template <class T>
  void write(const std::string& name, const std::vector<T>& values);

  // Results have more than columns, for readers of other projects.    Throws: Error limit, as write.
  // Writes a column of texts of any length, which NetCDF's readers take for text, too.
  void writeTexts(const std::string& name, const std::vector<std::string>& values);
  // Gives a column a second name.
  void link(const std::string& name, const std::string& column);
  // In: object: a column or group, "/" for the whole file; value: std::string, int64_t, double or std::vector<int64_t>
  template <class T>
  void setAttribute(const std::string& object, const std::string& name, const T& value);
  // Makes a column a dimension scale, by which readers know that other columns are as long and belong together.
  //   Source: The HDF Group, HDF5 Dimension Scale Specification, 2005.
  void makeScale(const std::string& column);
  // Says that a column has the dimension of a scale. A column with two names has one dimension.
  void useScale(const std::string& column, const std::string& scale);

  // Returns the bytes of the whole file. Call it last.    Throws: Error limit.
  std::vector<char> finish();

 private:
  Hdf5Silence silence_;
  int64_t id_;
  std::map<std::string, std::vector<std::string>> users_;  // of each scale
};

// Reads them back.
class Hdf5Input {
 public:
  // In: kind: of the file, and remedy: for a file that cannot be used, both for messages
  // Throws: Error bad_input where there is no such file, or its check sum is wrong.
  explicit Hdf5Input(const std::filesystem::path& file, const char* kind = "checkpoint",
                     const char* remedy = "take another, or remove it and start afresh");
  // Reads what Hdf5Output::finish returned.    In: name: for messages
  Hdf5Input(const std::vector<char>& bytes, const std::string& name, const char* kind, const char* remedy);
  ~Hdf5Input();
  Hdf5Input(const Hdf5Input&) = delete;

  // In: count: how many values there are to be, where it is known
  // Throws: Error bad_input where there is no such column of this type and length.
  template <class T>
  std::vector<T> read(const std::string& name, std::optional<size_t> count = {});
  // Reads a column of writeTexts.    Throws: Error bad_input where there is no such column.
  std::vector<std::string> readTexts(const std::string& name);
  // Returns the attributes of the whole file, in words; numbers as their shortest form that reads back to the same.
  std::vector<std::pair<std::string, std::string>> attributes();
  // In: name: of a column or group whose own group there is
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
