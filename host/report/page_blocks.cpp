#include "report/page_blocks.h"

#include <type_traits>

#include <fmt/format.h>
#include <zlib.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr int kCompression = 4;  // zlib's level: higher ones make form factors 1 % smaller and take twice the time

template <class T>
constexpr const char* typeName() {
  if constexpr (std::is_same_v<T, uint8_t>) return "u8";
  else if constexpr (std::is_same_v<T, int32_t>) return "i32";
  else if constexpr (std::is_same_v<T, float>) return "f32";
  else return "f64";
}

std::vector<uint8_t> shuffle(const uint8_t* bytes, size_t count, size_t width) {
  std::vector<uint8_t> shuffled(count * width);
  for (size_t k = 0; k < count; ++k)
    for (size_t byte = 0; byte < width; ++byte) shuffled[byte * count + k] = bytes[k * width + byte];
  return shuffled;
}

std::vector<uint8_t> deflateBytes(const std::vector<uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<uint8_t> deflated(size);
  if (compress2(deflated.data(), &size, bytes.data(), bytes.size(), kCompression) != Z_OK)
    throw Error(ErrorCode::limit, "zlib cannot make a page, probably for lack of memory; try --by surface");
  deflated.resize(size);
  return deflated;
}

std::string toBase64(const std::vector<uint8_t>& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t at = 0; at < bytes.size(); at += 3) {
    const size_t left = bytes.size() - at;
    const uint32_t word = bytes[at] << 16 | (left > 1 ? bytes[at + 1] << 8 : 0) | (left > 2 ? bytes[at + 2] : 0);
    text += kDigits[word >> 18 & 63];
    text += kDigits[word >> 12 & 63];
    text += left > 1 ? kDigits[word >> 6 & 63] : '=';
    text += left > 2 ? kDigits[word & 63] : '=';
  }
  return text;
}

}  // namespace

template <class T>
void PageBlocks::add(const std::string& name, const std::vector<T>& values) {
  addBytes(name, typeName<T>(), values.size(), sizeof(T), reinterpret_cast<const uint8_t*>(values.data()));
}

void PageBlocks::addTexts(const std::string& name, const std::vector<std::string>& texts) {
  std::vector<uint8_t> bytes;
  for (const std::string& text : texts) {
    for (char c : text)
      if (c != '\0') bytes.push_back(static_cast<uint8_t>(c));
    bytes.push_back(0);
  }
  addBytes(name, "text", bytes.size(), 1, bytes.data());
}

void PageBlocks::addBytes(const std::string& name, const char* type, size_t count, size_t width, const uint8_t* bytes) {
  list_ += fmt::format(R"({}{{"name":"{}","type":"{}","count":{}}})", list_.empty() ? "" : ",\n", name, type, count);
  blocks_.push_back(toBase64(deflateBytes(shuffle(bytes, count, width))));
  size_bytes_ += blocks_.back().size();
}

std::string PageBlocks::list() const { return "[" + list_ + "]"; }

std::string PageBlocks::elements() const {
  std::string text;
  text.reserve(size_bytes_ + blocks_.size() * 60);
  for (size_t k = 0; k < blocks_.size(); ++k)
    text += fmt::format("<script type=\"text/plain\" id=\"block-{}\">{}</script>\n", k, blocks_[k]);
  return text;
}

template void PageBlocks::add(const std::string&, const std::vector<uint8_t>&);
template void PageBlocks::add(const std::string&, const std::vector<int32_t>&);
template void PageBlocks::add(const std::string&, const std::vector<float>&);
template void PageBlocks::add(const std::string&, const std::vector<double>&);

}  // namespace viewpeel
