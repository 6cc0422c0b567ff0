// These functions sort and add up lists of counts of pairs.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// Says whether pair a comes before pair b: by i, then by j. It is a lambda, not a function, so that std::sort inlines
// it.
inline constexpr auto isBefore = [](const PairCount& a, const PairCount& b) {
  return a.i != b.i ? a.i < b.i : a.j < b.j;
};

// Returns the sums of two sorted lists of counts, sorted.
PairCounts addCounts(const PairCounts& a, const PairCounts& b);

// Returns the counts of all lists sorted, with counts of the same pair added up.
//   In: lists: in any order, with i < id_count
//   Cost: O(n) for n counts, plus sorting the counts of each i, on all threads.
PairCounts sortAndJoin(const std::vector<PairCounts>& lists, uint32_t id_count);

}  // namespace viewpeel
