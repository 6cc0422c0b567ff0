// These functions read the words and numbers of text formats. All readers share them.
#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {

// Removes the next word from the text and returns it; empty at the end of the text.
inline std::string_view nextWord(std::string_view& rest) {
  const size_t start = rest.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return rest = {};
  const size_t end = std::min(rest.find_first_of(" \t\r", start), rest.size());
  const std::string_view word = rest.substr(start, end - start);
  rest.remove_prefix(end);
  return word;
}

// Returns the remaining words, with one blank between them.
inline std::string joinWords(std::string_view rest) {
  std::string joined;
  for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
    if (!joined.empty()) joined += ' ';
    joined += word;
  }
  return joined;
}

// Returns the text without the byte order mark that some editors put at the beginning of UTF-8 files.
inline std::string_view skipByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(text.starts_with(kMark) ? kMark.size() : 0);
}

// Returns the text with '?' in place of control characters, so that it is one line in a message.
inline std::string withoutControls(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return out;
}

// Returns the first 20 bytes of a text for messages, without controls. It does not cut within a UTF-8 character.
inline std::string printable(std::string_view text) {
  size_t length = std::min<size_t>(text.size(), 20);
  while (length > 0 && length < text.size() && (text[length] & 0xC0) == 0x80) --length;
  return withoutControls(text.substr(0, length));
}

// A FilePlace is a line of a file, for messages. Line 0 means that the place has no line, as in a binary part. The file
// may have its name from another file, such as a table of materials.
struct FilePlace {
  std::string file;
  uint32_t line = 0;

  [[noreturn]] void refuse(const std::string& what) const {
    const std::string name = withoutControls(file);
    throw Error(ErrorCode::bad_input,
                line ? fmt::format("{}:{}: {}", name, line, what) : fmt::format("{}: {}", name, what));
  }
};

// Returns the number that a word spells.    Throws: Error bad_input where the word is not a finite number.
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
