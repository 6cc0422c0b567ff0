// Lists of counts of facing pairs: their order and their sums.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// The order of lists; no function, so that sorting inlines it.
inline constexpr auto isBefore = [](const PairCount& a, const PairCount& b) {
  return a.i != b.i ? a.i < b.i : a.j < b.j;
};

// The sum of two sorted lists of counts.
PairCounts addCounts(const PairCounts& a, const PairCounts& b);

// In order, equal pairs as one.
//   In: counts in any order, i < id_count    Cost: O(n) and the sorting of each i's own.
PairCounts sortAndJoin(const PairCounts& counts, uint32_t id_count);

}  // namespace viewpeel
