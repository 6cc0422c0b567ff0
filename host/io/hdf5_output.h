// HDF5 files here hold columns of numbers or texts, followed by a check sum of 8 bytes, little-endian, which readers of
// HDF5 ignore. HDF5 may crash on damaged files, so it never gets a file whose check sum is wrong. It may also crash on
// a full disk, so it makes files in memory. Values of large columns are written past it, one after another.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "io/hdf5_silence.h"

namespace viewpeel {

// A ByteSink takes the values of a column one by one, and passes their bytes on in blocks.
class ByteSink {
 public:
  explicit ByteSink(std::function<void(const std::vector<char>& bytes)> use);
  template <class T>
  void put(T value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    block_.insert(block_.end(), bytes, bytes + sizeof value);
    if (block_.size() >= kBlockBytes) flush();
  }
  // Takes the bytes of several values.
  void put(std::span<const char> bytes) {
    block_.insert(block_.end(), bytes.begin(), bytes.end());
    if (block_.size() >= kBlockBytes) flush();
  }
  // Passes the last bytes on.
  void flush();

 private:
  static constexpr size_t kBlockBytes = 1 << 16;
  std::function<void(const std::vector<char>& bytes)> use_;
  std::vector<char> block_;
};

// An Hdf5Output makes a file in memory and writes it out at the end. Columns are of uint8_t, int32_t, uint32_t,
// int64_t, uint64_t, double or std::string (all texts padded to the longest). The same columns make the same bytes.
class Hdf5Output {
 public:
  Hdf5Output();
  ~Hdf5Output();
  Hdf5Output(const Hdf5Output&) = delete;

  // Adds a column.    In: name: with slashes for groups    Throws: Error limit where memory is short.
  template <class T>
  void write(const std::string& name, const std::vector<T>& values);

  // Adds a column whose values are made when the file is written.
  //   In: count: of values; make: puts that many values of type T, from finish() on; empty where others write them
  //   (finishFrame)
  template <class T>
  void writeLater(const std::string& name, size_t count, std::function<void(ByteSink&)> make);

  // The functions from here to useScale() write what readers of other projects need.    Throws: Error limit, as write.
  // Writes a column of texts of any length, which readers of NetCDF recognise as texts.
  void writeTexts(const std::string& name, const std::vector<std::string>& values);
  // Gives a column a second name.
  void link(const std::string& name, const std::string& column);
  // Sets an attribute.    In: object: column or group, "/" for the file; value: std::string, int64_t, double or a
  // vector
  template <class T>
  void setAttribute(const std::string& object, const std::string& name, const T& value);
  // Makes a column a dimension scale, so that readers know which other columns belong to it, value by value.
  //   Source: The HDF Group, HDF5 Dimension Scale Specification, 2005.
  void makeScale(const std::string& column);
  // States that a column's dimension is the scale. Where a column has two names, call it for one.
  void useScale(const std::string& column, const std::string& scale);

  // Writes the whole file. Call it last.    Throws: Error limit; a failure to write is the state of `out`.
  void finish(std::ostream& out);
  // Returns the bytes of the whole file. Call it last.    Throws: Error limit.
  std::vector<char> finish();
  // Writes the file without the columns that others write, and without its check sum. Call it last.
  //   Out: the place of each of these columns among the bytes of the file, by name
  std::map<std::string, uint64_t> finishFrame(std::ostream& out);

 private:
  // A Later is a column of writeLater(): its place among the bytes of the file.
  struct Later {
    std::string name;
    uint64_t place, size;
    std::function<void(ByteSink&)> make;
  };
  void finishTo(const std::function<void(const std::vector<char>& bytes)>& use,
                const std::function<void(const Later& column)>& leave);

  Hdf5Silence silence_;
  int memory_;  // descriptor of the file in memory; -1: HDF5 has a buffer
  int64_t id_;
  std::vector<Later> later_;
  std::map<std::string, std::vector<std::string>> users_;  // by scale: the columns that use it
};

// Appends its check sum to a file whose columns have all been written.    Throws: Error output, naming the file.
void endFrame(const std::string& file);

}  // namespace viewpeel
