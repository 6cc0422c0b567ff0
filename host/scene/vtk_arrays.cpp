#include "scene/vtk_arrays.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <type_traits>

#include <zlib.h>

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are little-endian and copied as they are");

constexpr uint64_t kLargestArray = uint64_t(1) << 36;  // bytes
constexpr uint64_t kLargestRatio = 1032;               // no block of zlib grows by more

int valueOf(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Decodes base64 up to the end or a `=`, without blanks. `used` becomes the position of the next character.
std::string decodeBase64(std::string_view text, size_t& used) {
  std::string bytes;
  uint32_t bits = 0;
  int count = 0;
  for (used = 0; used < text.size(); ++used) {
    if (text[used] == '=') break;
    const int value = valueOf(text[used]);
    if (value < 0) continue;
    bits = bits << 6 | static_cast<uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xFF);
  }
  while (used < text.size() && text[used] == '=') ++used;
  return bytes;
}

// Returns the number of base64 characters for this number of bytes.
size_t base64Length(uint64_t bytes) { return static_cast<size_t>((bytes + 2) / 3 * 4); }

std::string_view skipBlanks(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view() : text.substr(first);
}

}  // namespace

VtkFile::VtkFile(const std::filesystem::path& file, const char* kind) : place_{file.string()} {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  // The appended bytes are not XML, so they are cut out before it is parsed.
  if (const size_t tag = text.find("<AppendedData"); tag != std::string::npos) {
    const size_t start = text.find('_', text.find('>', tag)), end = text.rfind("</AppendedData>");
    if (start == std::string::npos || end == std::string::npos || end < start)
      refuse("the file ends within its appended data; export it again");
    appended_ = text.substr(start + 1, end - start - 1);
    text.erase(start, end - start);
  }
  const pugi::xml_parse_result parsed = document_.load_buffer(text.data(), text.size());
  if (!parsed) refuse(fmt::format("not XML at byte {}: {}; export it again", parsed.offset, parsed.description()));
  const pugi::xml_node root = document_.child("VTKFile");
  grid_ = root.child(kind);
  if (!grid_) refuse(fmt::format("not a VTK file of {}; export it again", kind));
  if (root.attribute("byte_order").as_string() == std::string("BigEndian"))
    refuse("the file is big-endian; export it little-endian");
  const std::string compressor = root.attribute("compressor").as_string();
  is_compressed_ = !compressor.empty();
  if (is_compressed_ && compressor != "vtkZLibDataCompressor")
    refuse(fmt::format("compressed by {}; export it with zlib or without compression", printable(compressor)));
  if (root.attribute("header_type").as_string() == std::string("UInt64")) header_bytes_ = 8;
  appended_is_base64_ = root.child("AppendedData").attribute("encoding").as_string() != std::string("raw");
}

uint64_t VtkFile::headerAt(std::string_view bytes, size_t index) const {
  uint64_t value = 0;
  if (bytes.size() < (index + 1) * header_bytes_) refuse("an array is cut off in its header; export the file again");
  std::memcpy(&value, bytes.data() + index * header_bytes_, header_bytes_);
  if (value > kLargestArray) refuse("the length of an array is impossible; export the file again");
  return value;
}

// Decodes a block of an array. A plain block is its length and its bytes. A compressed block begins with the number of
// pieces, their length, the last one's length, and each compressed length. In base64 this header is encoded separately.
std::string VtkFile::decodeBlock(std::string_view encoded, bool is_base64) const {
  size_t used = 0;
  std::string decoded;
  std::string_view bytes = encoded;
  if (!is_compressed_) {
    if (is_base64) {
      const std::string head = decodeBase64(encoded.substr(0, base64Length(header_bytes_)), used);
      const uint64_t length = headerAt(head, 0);
      decoded = decodeBase64(encoded.substr(0, base64Length(header_bytes_ + length)), used);
      bytes = decoded;
    }
    const uint64_t length = headerAt(bytes, 0);
    if (bytes.size() < header_bytes_ + length) refuse("an array is cut off; export the file again");
    return std::string(bytes.substr(header_bytes_, length));
  }
  std::string head(encoded.substr(0, 3 * header_bytes_));
  if (is_base64) head = decodeBase64(encoded.substr(0, base64Length(3 * header_bytes_)), used);
  const uint64_t blocks = headerAt(head, 0), size = headerAt(head, 1), last = headerAt(head, 2);
  if (blocks > encoded.size()) refuse("an array has more blocks than bytes; export the file again");
  const size_t head_bytes = (3 + static_cast<size_t>(blocks)) * header_bytes_;
  std::string sizes(encoded.substr(0, head_bytes)), body;
  if (is_base64) {
    const std::string_view head_text = encoded.substr(0, base64Length(head_bytes));
    sizes = decodeBase64(head_text, used);
    uint64_t total = 0;
    for (size_t k = 0; k < blocks; ++k) total += headerAt(sizes, 3 + k);
    if (encoded.size() > head_text.size())
      body = decodeBase64(encoded.substr(head_text.size()).substr(0, base64Length(total)), used);
  } else if (encoded.size() > head_bytes) {
    body = encoded.substr(head_bytes);
  }
  std::string all;
  size_t at = 0;
  for (size_t k = 0; k < blocks; ++k) {
    const uint64_t compressed = headerAt(sizes, 3 + k), plain = k + 1 == blocks && last ? last : size;
    if (compressed > body.size() - at || plain > kLargestRatio * (compressed + 1))
      refuse("a compressed array is cut off; export the file again");
    std::string block(plain, '\0');
    uLongf length = static_cast<uLongf>(plain);
    if (uncompress(reinterpret_cast<Bytef*>(block.data()), &length, reinterpret_cast<const Bytef*>(body.data() + at),
                   static_cast<uLong>(compressed)) != Z_OK ||
        length != plain)
      refuse("a compressed array is damaged; export the file again");
    all += block;
    at += compressed;
  }
  return all;
}

std::string VtkFile::bytesOf(const pugi::xml_node& array) const {
  const std::string format = array.attribute("format").as_string();
  if (format == "binary") return decodeBlock(skipBlanks(array.text().get()), true);
  if (format != "appended") refuse(fmt::format("an array has format '{}'; export the file again", printable(format)));
  const uint64_t offset = array.attribute("offset").as_ullong();
  if (offset > appended_.size()) refuse("an array begins behind the end of the file; export it again");
  return decodeBlock(std::string_view(appended_).substr(offset), appended_is_base64_);
}

template <class T>
std::vector<T> VtkFile::read(const pugi::xml_node& array) const {
  const std::string type = array.attribute("type").as_string(), name = array.attribute("Name").as_string();
  std::vector<T> values;
  if (array.attribute("format").as_string() == std::string("ascii")) {
    std::string text = array.text().get();
    for (char& c : text)
      if (c == '\n') c = ' ';
    std::string_view rest = text;
    for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
      T value{};
      const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (failure != std::errc() || end != word.data() + word.size())
        refuse(fmt::format("'{}' in array '{}' is not a number; correct it", printable(word), printable(name)));
      values.push_back(value);
    }
    return values;
  }
  const std::string bytes = bytesOf(array);
  const auto convert = [&]<class Stored>(Stored) {
    for (size_t at = 0; at + sizeof(Stored) <= bytes.size(); at += sizeof(Stored)) {
      Stored stored;
      std::memcpy(&stored, bytes.data() + at, sizeof stored);
      if constexpr (std::is_floating_point_v<Stored> && std::is_integral_v<T>) {
        refuse(fmt::format("array '{}' is not of whole numbers", printable(name)));
      } else {
        values.push_back(static_cast<T>(stored));
      }
    }
  };
  if (type == "Float64") convert(double{});
  else if (type == "Float32") convert(float{});
  else if (type == "Int64") convert(int64_t{});
  else if (type == "UInt64") convert(uint64_t{});
  else if (type == "Int32") convert(int32_t{});
  else if (type == "UInt32") convert(uint32_t{});
  else if (type == "Int16") convert(int16_t{});
  else if (type == "UInt16") convert(uint16_t{});
  else if (type == "Int8") convert(int8_t{});
  else if (type == "UInt8" || type == "String") convert(uint8_t{});
  else refuse(fmt::format("array '{}' has type '{}', which is not read", printable(name), printable(type)));
  return values;
}

std::vector<double> VtkFile::numbers(const pugi::xml_node& array) const { return read<double>(array); }

std::vector<int64_t> VtkFile::integers(const pugi::xml_node& array) const { return read<int64_t>(array); }

std::vector<std::string> VtkFile::texts(const pugi::xml_node& array) const {
  std::vector<std::string> all(1);
  for (int64_t code : read<int64_t>(array)) {
    if (code == 0) all.emplace_back();
    else all.back() += static_cast<char>(code);
  }
  all.pop_back();
  return all;
}

}  // namespace viewpeel
