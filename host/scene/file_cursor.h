// A FileCursor reads a file that is text in one part and binary in another.
#pragma once
#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "scene/words.h"

namespace viewpeel {

static_assert(std::endian::native == std::endian::little, "binary parts are little-endian and copied as they are");

// A FileCursor reads words, lines and numbers one after the other. Its messages name the line, until it has read a
// binary part.
class FileCursor {
 public:
  explicit FileCursor(const std::filesystem::path& file) : file_(file.string()) {
    std::ifstream in(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
    at_ = bytes_.size() - skipByteOrderMark(bytes_).size();
  }

  [[noreturn]] void refuse(const std::string& what) const {
    const auto line = 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(word_), '\n');
    FilePlace{file_, is_binary_ ? 0 : static_cast<uint32_t>(line)}.refuse(what);
  }

  bool isAtEnd() const { return bytes_.find_first_not_of(" \t\r\n", at_) == std::string::npos; }
  // Returns the next word, from this line or a later one. It is empty at the end of the file.
  std::string_view word() {
    word_ = std::min(bytes_.find_first_not_of(" \t\r\n", at_), bytes_.size());
    at_ = std::min(bytes_.find_first_of(" \t\r\n", word_), bytes_.size());
    return std::string_view(bytes_).substr(word_, at_ - word_);
  }
  // Returns the rest of the line, and moves to the next line.
  std::string_view line() {
    word_ = at_;
    const size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    at_ = std::min(end + 1, bytes_.size());
    std::string_view text = std::string_view(bytes_).substr(word_, end - word_);
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
  }
  // Moves behind the next occurrence of a text.
  void skipPast(std::string_view text) {
    word_ = at_;
    const size_t found = bytes_.find(text, at_);
    if (found == std::string::npos) refuse(fmt::format("the file ends before '{}'; export it again", printable(text)));
    at_ = found + text.size();
  }

  template <class T>
  T number(const char* what) {
    if constexpr (std::is_floating_point_v<T>) {
      const std::string_view text = word();
      if (text.empty()) refuse(fmt::format("the file ends before {}; export it again", what));
      T value = 0;
      const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (failure == std::errc::invalid_argument || end != text.data() + text.size() || !std::isfinite(value))
        refuse(fmt::format("'{}' in the place of {} is not a finite number; correct it", printable(text), what));
      return value;
    } else {
      const std::string_view text = word();
      if (text.empty()) refuse(fmt::format("the file ends before {}; export it again", what));
      T value = 0;
      const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (failure != std::errc() || end != text.data() + text.size())
        refuse(fmt::format("'{}' in the place of {} is not a whole number; correct it", printable(text), what));
      return value;
    }
  }
  template <class T>
  T raw(const char* what) {
    is_binary_ = true;
    T value;
    if (bytes_.size() - at_ < sizeof value) refuse(fmt::format("the file ends within {}; export it again", what));
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }

 private:
  std::string file_, bytes_;
  size_t at_ = 0, word_ = 0;
  bool is_binary_ = false;
};

}  // namespace viewpeel
