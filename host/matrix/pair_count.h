// Counts of facing pairs: what every engine returns and the estimator sums.
#pragma once
#include <cstdint>
#include <vector>

namespace viewpeel {

// Stand in the place of a second id: lines of the first id that leave the scene, and that end on a back.
constexpr uint32_t kEnvironment = 0xFFFFFFFEu;
constexpr uint32_t kLeak = 0xFFFFFFFFu;

// How often ids i <= j were consecutive and facing, summed over directions, in the engine's unit of area.
struct PairCount {
  uint32_t i, j;
  uint64_t count;
};

// Sorted by (i, j), every pair at most once, no zero counts.
using PairCounts = std::vector<PairCount>;

}  // namespace viewpeel
