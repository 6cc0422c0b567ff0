// parseJson() reads the JSON of scene files.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "scene/words.h"

namespace viewpeel {

// Parses JSON; members stay in the order of the text.
//   In: place: of the text in its file, with its first line, or 0 for a text that begins its file; callback: as
//     nlohmann::json's parser takes it, or none
//   Throws: Error bad_input, naming the line, for a text that is not JSON; as requireShallow().
nlohmann::ordered_json parseJson(const std::string& text, const FilePlace& place,
                                 const nlohmann::ordered_json::parser_callback_t& callback = nullptr);

// Throws Error bad_input where JSON is nested so deeply that a parser might exhaust the stack.
//   In: text, place: as for parseJson
void requireShallow(const std::string& text, const FilePlace& place);

}  // namespace viewpeel
