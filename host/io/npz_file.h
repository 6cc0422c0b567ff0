// NumPy's .npz is a zip of .npy arrays, stored without compression, with the 64-bit sizes of ZIP64 throughout.
//   Sources: the NPY format, version 1.0 (numpy.lib.format); PKWARE, APPNOTE.TXT 6.3.9, sections 4.3 and 4.5.3.
#pragma once
#include <cstdint>
#include <functional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace viewpeel {

// An NpzOutput writes arrays one after the other. The same arrays make the same bytes.
class NpzOutput {
 public:
  // In: out: at the beginning of the file
  explicit NpzOutput(std::ostream& out) : out_(out) {}

  // Adds NAME.npy, an array of one dimension.    In: values: int32_t, int64_t or double
  template <class T>
  void write(const std::string& name, std::span<const T> values);
  using UseBytes = std::function<void(std::span<const char>)>;
  // Adds NAME.npy without having all of it in memory.
  //   In: count: number of values, which are of type T; forEachPart(use): makes the bytes of all values in parts, and
  //   calls use(bytes) for each part. It is called twice, and must give the same bytes.
  template <class T>
  void write(const std::string& name, size_t count, const std::function<void(const UseBytes&)>& forEachPart);
  // Adds NAME.npy: one text, as an array of bytes without dimensions.
  void writeText(const std::string& name, const std::string& text);
  // Writes the directory of the zip. Call it last.
  void finish();

 private:
  struct Member {
    std::string name;
    uint32_t check_sum;
    uint64_t size, place;
  };
  // Adds a member.    In: size: of all parts; forEachPart: as in write()
  void add(const std::string& name, const std::string& head, size_t size,
           const std::function<void(const UseBytes&)>& forEachPart);
  std::ostream& out_;
  std::vector<Member> members_;
  uint64_t place_ = 0;
};

}  // namespace viewpeel
