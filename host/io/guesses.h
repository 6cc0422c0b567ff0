// The value of a pair that no line met is a guess from neighbouring pairs; files mark these entries.
#pragma once
#include <algorithm>
#include <utility>

#include <viewpeel/write.h>

namespace viewpeel {

inline bool hasGuesses(const OutputContent& content) { return content.guesses && !content.guesses->empty(); }

// Returns whether the entry of a pair is a guess.    Cost: O(log guesses).
inline bool isGuess(const OutputContent& content, uint32_t i, uint32_t j) {
  return content.guesses && std::ranges::binary_search(*content.guesses, std::pair(std::min(i, j), std::max(i, j)));
}

}  // namespace viewpeel
