// A VtkFile reads the arrays of a VTK XML file. They may be text, base64 or appended, and plain or compressed by zlib.
//   Source: Kitware, The VTK User's Guide, 11th edition, VTK file formats.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "scene/words.h"

namespace viewpeel {

// A VtkFile holds the XML of a file, and the bytes appended to it.
class VtkFile {
 public:
  // Reads the file.
  //   In: kind: the type of data set, "PolyData" or "UnstructuredGrid"
  //   Throws: Error bad_input where the file is no VTK file of this kind, or is big-endian.
  VtkFile(const std::filesystem::path& file, const char* kind);

  // Returns the node that holds the pieces.
  pugi::xml_node grid() const { return grid_; }
  // Reads an array of numbers, or of texts.
  //   In: array: a DataArray node    Throws: Error bad_input naming the array.
  std::vector<double> numbers(const pugi::xml_node& array) const;
  std::vector<int64_t> integers(const pugi::xml_node& array) const;
  std::vector<std::string> texts(const pugi::xml_node& array) const;
  [[noreturn]] void refuse(const std::string& what) const { place_.refuse(what); }

 private:
  std::string bytesOf(const pugi::xml_node& array) const;
  std::string decodeBlock(std::string_view encoded, bool is_base64) const;
  uint64_t headerAt(std::string_view bytes, size_t index) const;
  template <class T>
  std::vector<T> read(const pugi::xml_node& array) const;

  FilePlace place_;
  pugi::xml_document document_;
  pugi::xml_node grid_;
  std::string appended_;
  bool appended_is_base64_ = false, is_compressed_ = false;
  size_t header_bytes_ = 4;
};

}  // namespace viewpeel
