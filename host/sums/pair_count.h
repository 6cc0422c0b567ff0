// Lists of counts of facing pairs have one order, and add up.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// Lists are in this order. It is no function, so that sorting inlines it.
inline constexpr auto isBefore = [](const PairCount& a, const PairCount& b) {
  return a.i != b.i ? a.i < b.i : a.j < b.j;
};

// Returns the sum of two sorted lists of counts.
PairCounts addCounts(const PairCounts& a, const PairCounts& b);

// Sorts counts and adds equal pairs.
//   In: counts in any order, i < id_count    Cost: O(n) and the sorting of each i's own.
PairCounts sortAndJoin(const PairCounts& counts, uint32_t id_count);

}  // namespace viewpeel
