#include "io/csv.h"

#include <algorithm>

namespace viewpeel {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const size_t start = std::min(text.find_first_not_of(kBlanks), text.size());
  return text.substr(start, text.find_last_not_of(kBlanks) + 1 - start);
}

}  // namespace

std::string quoteName(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (char c : name) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

bool splitLine(std::string_view line, std::vector<std::string>& fields) {
  fields.clear();
  while (true) {
    const size_t start = std::min(line.find_first_not_of(kBlanks), line.size());
    size_t comma = line.find(',');
    if (start == line.size() || line[start] != '"') {
      fields.emplace_back(trimmed(line.substr(0, comma)));
    } else {
      std::string field;
      size_t at = start + 1;
      for (; at < line.size() && (line[at] != '"' || line.substr(at, 2) == "\"\""); ++at) {
        field += line[at];
        at += line[at] == '"';
      }
      if (at >= line.size()) return false;
      comma = line.find(',', at);
      if (!trimmed(line.substr(at + 1, comma == std::string_view::npos ? comma : comma - at - 1)).empty()) return false;
      fields.push_back(std::move(field));
    }
    if (comma == std::string_view::npos) return true;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace viewpeel
