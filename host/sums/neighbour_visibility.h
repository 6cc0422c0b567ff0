// A pair that no line hit takes the visibility of its neighbours' lines. Derivation: docs/method.md, section 7.
//
// Most runs miss a pair that few lines are expected to hit. An exchange area of 0 would then nearly always be wrong:
// most pairs of a room see each other whole. Lines between the faces around either one see nearly the same, so their
// share of facing lines stands for the pair's. It is a guess, and the spread of visibilities among neighbours is its
// standard error. Where a pair has few lines, its visibility is made of theirs and its neighbours'.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sums/visibility_sums.h"

namespace viewpeel {

class NeighbourVisibility {
 public:
  struct Value {
    float mean, smoothed;  // of() has both

    float deviation() const { return std::sqrt(smoothed * (1 - smoothed)); }
  };

  // Computes the visibilities of all blocks.
  //   In: lines: as in lineOf; ranks: of ids, as rankByPlace makes them; referred to
  //   Cost: O(pairs + (n / 4)^2) work, 16 bytes for each of the latter.
  NeighbourVisibility(const VisibilitySums& sums, const std::vector<uint64_t>& lines,
                      const std::vector<uint32_t>& ranks);

  // Returns m of eq. (19) and s of eq. (20), from the lines between the 4 ids around i and the 4 around j, by rank.
  // However many lines one pair has, they say little about its neighbours: n count as 1.5 n / (n + 0.5).
  //   Error: m may be off by the root of s (1 - s): no visibility spreads more about its mean s. Measured:
  //     tests/unit/neighbour_visibility_test.cpp.
  Value of(uint32_t i, uint32_t j) const { return visibilities_[blockOf(ranks_[i], ranks_[j])]; }

  // The neighbours' m counts as this many lines beside a pair's own.
  static constexpr float kNeighbours = 0.5f;

 private:
  size_t blockOf(uint32_t rank_a, uint32_t rank_b) const {
    const auto [a, b] = std::minmax({rank_a >> kStep, rank_b >> kStep});
    return size_t(a) * side_ + b;
  }

  static constexpr uint32_t kStep = 2;  // bits of a rank from one size of blocks to the next

  std::span<const uint32_t> ranks_;
  size_t side_;
  std::vector<Value> visibilities_;  // of blocks of 4 x 4 ids; blocks below the diagonal are not used
};

}  // namespace viewpeel
