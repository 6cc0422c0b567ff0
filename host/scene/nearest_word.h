// nearestWord() guesses what was meant by a word that is unknown: an option, a subcommand or a surface.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace viewpeel {

// Returns the word that begins with `given`, or the nearest word if at most a third of its letters differ.
//   Cost: O(words x length^2).
std::optional<std::string> nearestWord(const std::string& given, const std::vector<std::string>& words);

}  // namespace viewpeel
