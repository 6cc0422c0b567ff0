// A FoamFile is a file of OpenFOAM: a header, then lists as text or binary, plain or compressed by gzip.
//   Source: OpenFOAM User Guide, basic input/output file format; the files of OpenFOAM v1912.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace viewpeel {

// FoamLists are lists one after the other: list k is values[starts[k]] to values[starts[k + 1] - 1].
struct FoamLists {
  std::vector<uint64_t> starts = {0};
  std::vector<int64_t> values;

  size_t count() const { return starts.size() - 1; }
  uint64_t size(size_t k) const { return starts[k + 1] - starts[k]; }
  const int64_t* begin(size_t k) const { return values.data() + starts[k]; }
};

class FoamFile {
 public:
  // Opens `file`, or `file`.gz, and reads the header.
  //   Throws: Error bad_input where neither file exists, or the header is wrong.
  explicit FoamFile(const std::filesystem::path& file);

  static bool exists(const std::filesystem::path& file);
  const std::string& className() const { return class_; }
  // These functions read the next item.    Throws: Error bad_input, naming the line where the file is text.
  uint64_t count(const char* what);
  std::vector<double> points();  // x, y, z of each point
  FoamLists lists();             // lists of labels
  FoamLists faces();             // lists of points, or the compact form of binary files
  std::string word();            // up to a blank or one of ; { } ( ), or one of these characters; empty at the end
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  void readHeader();
  void skipBlanks();
  void expect(char bracket, const char* what);
  bool takes(char bracket);
  int64_t label(const char* what);
  double scalar(const char* what);
  void addLabels(FoamLists& lists, const char* what);
  std::string_view raw(uint64_t bytes, const char* what);

  std::string file_, bytes_, class_;
  size_t at_ = 0;
  bool is_binary_ = false;
  size_t label_bytes_ = 4, scalar_bytes_ = 8;
  uint64_t repeated_ = 0;  // values of lists that give one value for all
};

}  // namespace viewpeel
