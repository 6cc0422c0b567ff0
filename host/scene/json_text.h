// parseJson() reads the JSON of scene files.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "scene/words.h"

namespace viewpeel {

// Parses JSON; members stay in the order of the text.
//   In: place: of the text in its file; line: of its first line, or 0 for a text that begins its file
//   Throws: Error bad_input, naming the line, for a text that is not JSON; without a line for one that is nested so
//     deeply that the parser would exhaust the stack.
nlohmann::ordered_json parseJson(const std::string& text, const FilePlace& place);

// Throws Error bad_input where JSON is nested too deeply.    In: text, place: as for parseJson
void requireShallow(const std::string& text, const FilePlace& place);

}  // namespace viewpeel
