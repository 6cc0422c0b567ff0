// The readers share these functions for words and numbers of text formats.
#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {

// Splits off the next word; empty at the end.
inline std::string_view nextWord(std::string_view& rest) {
  const size_t start = rest.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return rest = {};
  const size_t end = std::min(rest.find_first_of(" \t\r", start), rest.size());
  const std::string_view word = rest.substr(start, end - start);
  rest.remove_prefix(end);
  return word;
}

// Returns all words that are left, one blank between them.
inline std::string joinWords(std::string_view rest) {
  std::string joined;
  for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
    if (!joined.empty()) joined += ' ';
    joined += word;
  }
  return joined;
}

// Returns the text without the mark that some editors begin UTF-8 files with.
inline std::string_view skipByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(text.starts_with(kMark) ? kMark.size() : 0);
}

// Returns the text short and without control characters, for messages. UTF-8 is not cut within a character.
inline std::string printable(std::string_view text) {
  size_t length = std::min<size_t>(text.size(), 20);
  while (length > 0 && length < text.size() && (text[length] & 0xC0) == 0x80) --length;
  std::string out(text.substr(0, length));
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return out;
}

// Where in a file something is wrong; line 0 stands for a binary part.
struct FilePlace {
  std::string file;
  uint32_t line = 0;

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::bad_input,
                line ? fmt::format("{}:{}: {}", file, line, what) : fmt::format("{}: {}", file, what));
  }
};

// Throws: Error bad_input where the word is not a finite number.
inline double parseFinite(std::string_view word, const FilePlace& place) {
  std::string_view digits = word;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool is_number = failure != std::errc::invalid_argument && end == digits.data() + digits.size();
  if (!is_number) place.refuse(fmt::format("'{}' is not a number; correct it", printable(word)));
  if (failure != std::errc() || !std::isfinite(value))
    place.refuse(fmt::format("'{}' is not a finite number; correct it", printable(word)));
  return value;
}

}  // namespace viewpeel
