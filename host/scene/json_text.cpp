#include "scene/json_text.h"

#include <algorithm>

namespace viewpeel {

void requireShallow(const std::string& text, const FilePlace& place) {
  constexpr int kMostDepth = 64;
  int depth = 0;
  for (char c : text) {
    depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
    if (depth > kMostDepth) place.refuse("objects are nested too deeply; export the file again");
  }
}

nlohmann::ordered_json parseJson(const std::string& text, const FilePlace& place,
                                 const nlohmann::ordered_json::parser_callback_t& callback) {
  requireShallow(text, place);
  try {
    return nlohmann::ordered_json::parse(text, callback);
  } catch (const nlohmann::json::exception& error) {
    const auto* fault = dynamic_cast<const nlohmann::json::parse_error*>(&error);
    const size_t byte = fault ? std::min(fault->byte, text.size()) : 0;
    const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    FilePlace{place.file, std::max(place.line, 1u) + static_cast<uint32_t>(lines)}.refuse("not JSON here; correct it");
  }
}

}  // namespace viewpeel
