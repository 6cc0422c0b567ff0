// NeighbourVisibility guesses the visibility of pairs that no line met from lines between neighbouring pairs.
// Derivation: docs/method.md, section 7.
//
// In most runs no line meets a pair of small, distant faces. An exchange area of 0 would then nearly always be wrong,
// because most pairs of a room see each other whole. Lines between the faces around i and the faces around j see nearly
// the same, so the share of them that is facing is taken for the pair's visibility. This is a guess; its standard error
// is the spread of visibilities among neighbours. The visibility of a pair with few lines is a mean of both, eq. (21).
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
  // A Value is the visibility of a pair's neighbours.
  struct Value {
    float mean, smoothed;  // m of eq. (19) and s of eq. (20)

    // Returns the standard error of m as a guess of the pair's visibility.
    float deviation() const { return std::sqrt(smoothed * (1 - smoothed)); }
  };

  // Computes the visibilities between all groups of 4 ids.
  //   In: sums: the counted lines; lines: as in lineOf; ranks: rank of each id by place, as rankByPlace() returns it;
  //     the caller keeps it alive
  //   Cost: O(pairs + (n / 4)^2) work and 16 (n / 4)^2 bytes for n ids.
  NeighbourVisibility(const VisibilitySums& sums, const std::vector<uint64_t>& lines,
                      const std::vector<uint32_t>& ranks);

  // Returns the visibility of the neighbours of a pair (i, j), from the lines between the 4 ids around i and the 4 ids
  // around j by rank. However many lines n one pair has, they say little about other pairs, so they count as
  // 1.5 n / (n + 0.5).
  //   Error: the standard error of m is the root of s (1 - s). Numbers between 0 and 1 whose mean is s have no larger
  //     standard deviation. Measured: tests/unit/neighbour_visibility_test.cpp.
  Value of(uint32_t i, uint32_t j) const { return visibilities_[blockOf(ranks_[i], ranks_[j])]; }

  // The neighbours' m counts as much as this number of lines of the pair itself, eq. (21).
  static constexpr float kNeighbours = 0.5f;

 private:
  size_t blockOf(uint32_t rank_a, uint32_t rank_b) const {
    const auto [a, b] = std::minmax({rank_a >> kStep, rank_b >> kStep});
    return size_t(a) * side_ + b;
  }

  static constexpr uint32_t kStep = 2;  // each level has groups 2^kStep times as large as the level before

  std::span<const uint32_t> ranks_;
  size_t side_;
  std::vector<Value> visibilities_;  // Value[side_][side_], of groups a and b of 4 ids; unused where a > b
};

}  // namespace viewpeel
