// readPly() reads PLY, text and binary of either byte order: element `vertex` with x, y, z and element `face` with a
// list of vertex indices.
#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <iterator>

#include "scene/readers.h"
#include "scene/words.h"

namespace viewpeel {
namespace {

enum class Format { text, little_endian, big_endian };

struct Type {
  std::string_view names[2];
  size_t size_bytes;
  double (*decode)(const char*);
};

template <class T>
double decodeAs(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return double(value);
}

constexpr Type kTypes[] = {{{"char", "int8"}, 1, decodeAs<int8_t>},    {{"uchar", "uint8"}, 1, decodeAs<uint8_t>},
                           {{"short", "int16"}, 2, decodeAs<int16_t>}, {{"ushort", "uint16"}, 2, decodeAs<uint16_t>},
                           {{"int", "int32"}, 4, decodeAs<int32_t>},   {{"uint", "uint32"}, 4, decodeAs<uint32_t>},
                           {{"float", "float32"}, 4, decodeAs<float>}, {{"double", "float64"}, 8, decodeAs<double>}};

struct Property {
  std::string name;
  const Type* type = nullptr;
  const Type* count_type = nullptr;  // of a list's length; null for other properties
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file) : place_{file.string()} {
    std::ifstream in(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
    rest_ = skipByteOrderMark(bytes_);
    scene_ = {file.string(), {file.stem().string()}, {}};
  }

  InputScene read() {
    readHeader();
    if (format_ != Format::text) place_.line = 0;
    for (const Element& element : elements_)
      for (uint64_t k = 0; k < element.count; ++k) readRecord(element);
    for (const auto& [indices, line] : faces_) addFace(indices, line);
    return std::move(scene_);
  }

 private:
  std::string_view nextLine() {
    if (rest_.empty()) place_.refuse("the file ends too early; export it again");
    const size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++place_.line;
    return line;
  }

  const Type* typeNamed(std::string_view name) const {
    for (const Type& type : kTypes)
      if (name == type.names[0] || name == type.names[1]) return &type;
    place_.refuse(fmt::format("'{}' is not a type; correct it", printable(name)));
  }

  void readHeader() {
    std::string_view line = nextLine();
    if (nextWord(line) != "ply") place_.refuse("not a PLY file: its first line is not 'ply'");
    bool has_format = false;
    for (;;) {
      line = nextLine();
      const std::string_view keyword = nextWord(line);
      if (keyword == "end_header") break;
      if (keyword == "format") {
        const std::string_view name = nextWord(line);
        has_format = true;
        if (name == "ascii") format_ = Format::text;
        else if (name == "binary_little_endian") format_ = Format::little_endian;
        else if (name == "binary_big_endian") format_ = Format::big_endian;
        else place_.refuse(fmt::format("'{}' is not a PLY format; use ascii or binary", printable(name)));
      } else if (keyword == "element") {
        Element element;
        element.name = nextWord(line);
        const double count = parseFinite(nextWord(line), place_);
        if (count < 0 || count > 4e9 || count != std::floor(count))
          place_.refuse("an element's count is out of range; correct it");
        element.count = static_cast<uint64_t>(count);
        elements_.push_back(element);
      } else if (keyword == "property") {
        if (elements_.empty()) place_.refuse("a property comes before any element; correct it");
        Property property;
        std::string_view type = nextWord(line);
        if (type == "list") {
          property.count_type = typeNamed(nextWord(line));
          type = nextWord(line);
        }
        property.type = typeNamed(type);
        property.name = nextWord(line);
        elements_.back().properties.push_back(property);
      } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
        place_.refuse(fmt::format("'{}' is not a PLY header line; correct it", printable(keyword)));
      }
    }
    if (!has_format) place_.refuse("the header has no 'format' line; add it");
    for (const Element& element : elements_) checkProperties(element);
  }

  // Refuses elements without properties: their records take no bytes, so a short file could announce billions of them.
  void checkProperties(const Element& element) const {
    const auto require = [&](bool has, std::string_view what) {
      if (!has && element.count > 0)
        place_.refuse(fmt::format("element '{}' has no {}; export the file again", printable(element.name), what));
    };
    const auto has = [&](auto is_wanted) {
      return std::any_of(element.properties.begin(), element.properties.end(), is_wanted);
    };
    require(!element.properties.empty(), "property");
    for (const char* axis : {"x", "y", "z"})
      if (element.name == "vertex")
        require(has([&](const Property& property) { return property.name == axis && !property.count_type; }),
                fmt::format("property '{}'", axis));
    if (element.name == "face") require(has(isCornerList), "list 'vertex_indices'");
  }

  static bool isCornerList(const Property& property) {
    return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  double readNumber(const Type& type) {
    if (format_ == Format::text) {
      std::string_view word = nextWord(line_);
      if (word.empty()) place_.refuse("a line has too few numbers; complete it");
      return parseFinite(word, place_);
    }
    if (rest_.size() < type.size_bytes) place_.refuse("the file ends too early; export it again");
    char bytes[8];
    std::memcpy(bytes, rest_.data(), type.size_bytes);
    rest_.remove_prefix(type.size_bytes);
    if ((format_ == Format::big_endian) != (std::endian::native == std::endian::big))
      std::reverse(bytes, bytes + type.size_bytes);
    const double value = type.decode(bytes);
    if (!std::isfinite(value)) place_.refuse("a coordinate is not a finite number; correct it");
    return value;
  }

  void readRecord(const Element& element) {
    if (format_ == Format::text) do
        line_ = nextLine();
      while (line_.find_first_not_of(" \t\r") == std::string_view::npos);
    glm::dvec3 corner(0);
    std::vector<double> indices;
    for (const Property& property : element.properties) {
      if (property.count_type) {
        const double count = readNumber(*property.count_type);
        if (count < 0 || count != std::floor(count))
          place_.refuse(fmt::format("{} is not the length of a list; correct it", count));
        const bool wanted = isCornerList(property);
        for (double k = 0; k < count; ++k) {
          const double index = readNumber(*property.type);
          if (wanted) indices.push_back(index);
        }
      } else {
        const double value = readNumber(*property.type);
        for (int axis = 0; axis < 3; ++axis)
          if (property.name.size() == 1 && property.name[0] == "xyz"[axis]) corner[axis] = value;
      }
    }
    if (element.name == "vertex") vertices_.push_back(corner);
    if (element.name == "face") faces_.emplace_back(std::move(indices), place_.line);
  }

  void addFace(const std::vector<double>& indices, uint32_t line) {
    const FilePlace place{place_.file, line};
    if (indices.size() < 3) place.refuse("a face needs three corners or more; complete or remove it");
    InputFace face{{}, 0, line};
    for (double index : indices) {
      if (!(index >= 0 && index < double(vertices_.size())) || index != std::floor(index))
        place.refuse(fmt::format("vertex index {} is out of range; the file has {} vertices", index, vertices_.size()));
      face.corners.push_back(vertices_[static_cast<size_t>(index)]);
    }
    scene_.faces.push_back(std::move(face));
  }

  FilePlace place_;
  std::string bytes_;
  std::string_view rest_, line_;
  Format format_ = Format::text;
  std::vector<Element> elements_;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::pair<std::vector<double>, uint32_t>> faces_;  // vertex indices, and the line
  InputScene scene_;
};

}  // namespace

InputScene readPly(const std::filesystem::path& file) { return PlyReader(file).read(); }

}  // namespace viewpeel
