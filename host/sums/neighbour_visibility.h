// What the lines of a pair's neighbours tell of a pair that no line met.
//
// Of a pair that few lines are expected to meet, most runs meet none, and taking its exchange area for 0 then is wrong
// nearly always: of the pairs of a room most see each other whole. Lines between the faces around the one and those
// around the other see nearly the same, so that their share of facing ones stands for the pair's. It is a guess that
// lines confirm: an error of its own, the spread of visibilities among neighbours, is stated with it. And where few
// lines tell of a pair, its visibility is made of theirs and its neighbours'.
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
    float mean, smoothed;  // below

    float deviation() const { return std::sqrt(smoothed * (1 - smoothed)); }
  };

  //   In: lines: as in lineOf; ranks: of ids, as rankByPlace makes them; referred to    Cost: O(pairs + (n / 4)^2)
  //   work, 16 bytes for each of the latter.
  NeighbourVisibility(const VisibilitySums& sums, const std::vector<uint64_t>& lines,
                      const std::vector<uint32_t>& ranks);

  // Of lines between the 4 ids around i and the 4 around j, by rank: m = (V + m') / (L + 1) for L lines, V of them
  // facing, and m' the same of 16 ids around each, and so on up to all of the scene's. However many lines tell of one
  // pair, they say little of its neighbours: n count as 1.5 n / (n + 0.5), as they do where visibilities are mostly 0
  // or 1 (a beta distribution with parameters that add up to kNeighbours; Casella, An introduction to empirical Bayes
  // data analysis, The American Statistician 39, 1985).
  //   Error: m may be off by the root of s (1 - s) with s = (V + m' + 0.1) / (L + 1.2): no visibility spreads more
  //   about its mean s. Measured: tests/unit/neighbour_visibility_test.cpp.
  Value of(uint32_t i, uint32_t j) const { return visibilities_[blockOf(ranks_[i], ranks_[j])]; }

  // What the neighbours' m counts beside lines of a pair's own, in lines.
  static constexpr float kNeighbours = 0.5f;

 private:
  size_t blockOf(uint32_t rank_a, uint32_t rank_b) const {
    const auto [a, b] = std::minmax({rank_a >> kStep, rank_b >> kStep});
    return size_t(a) * side_ + b;
  }

  static constexpr uint32_t kStep = 2;  // bits of a rank from one size of blocks to the next

  std::span<const uint32_t> ranks_;
  size_t side_;
  std::vector<Value> visibilities_;  // of blocks of 4 x 4 ids; those below the diagonal are not used
};

}  // namespace viewpeel
