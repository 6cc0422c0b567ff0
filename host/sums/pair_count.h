// Counts of facing pairs: what every engine returns and the estimator sums.
//
// On a line that meets several polygons two of them face each other where the front of the nearer looks ahead and that of the farther looks back. They are
// counted as facing pair where they are consecutive, and as blocked where others lie between them. Facing and blocked together are all lines on which two
// fronts look at each other: along one direction, the common part of two projections, whatever else the scene holds.
#pragma once
#include <cstdint>
#include <vector>

#include "result/ids.h"

namespace viewpeel {

// Summed over directions, in the engine's unit of area.
struct PairCount {
  uint32_t i, j;         // i <= j
  uint64_t count;        // of lines on which they are consecutive and face each other
  uint64_t blocked = 0;  // of lines on which they face each other with others between them, where the engine was asked for it

  void add(const PairCount& other) {
    count += other.count;
    blocked += other.blocked;
  }
};

// Sorted by (i, j), every pair at most once, none with both counts 0.
using PairCounts = std::vector<PairCount>;

// The order of lists; no function, so that sorting inlines it.
inline constexpr auto isBefore = [](const PairCount& a, const PairCount& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; };

// The sum of two sorted lists of counts.
PairCounts addCounts(const PairCounts& a, const PairCounts& b);

// In order, equal pairs as one.
//   In: counts in any order, i < id_count    Cost: O(n) and the sorting of each i's own.
PairCounts sortAndJoin(const PairCounts& counts, uint32_t id_count);

}  // namespace viewpeel
