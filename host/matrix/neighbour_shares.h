// What the lines of a pair's neighbours tell of a pair that no line met.
//
// Of a pair that few lines are expected to meet, most runs meet none, and taking its exchange area for 0 then is wrong nearly always: of the pairs of a room most see each other whole. Lines
// between the faces around the one and those around the other see nearly the same, so that their share of facing ones stands for the pair's. It is a guess that lines confirm: an error of
// its own, the spread of shares among neighbours, is stated with it.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "matrix/share_sums.h"

namespace viewpeel {

class NeighbourShares {
 public:
  struct Share {
    float mean, deviation;
  };

  //   In: lines: as in lineOf; ranks: of ids, as rankByPlace makes them; referred to    Cost: O(pairs + (n / 4)^2) work, 16 bytes for each of the latter.
  NeighbourShares(const ShareSums& sums, const std::vector<uint64_t>& lines, const std::vector<uint32_t>& ranks);

  // Of lines between the 4^k ids around i and the 4^k around j, by rank, for the least k with kEnoughLines of them; all of the scene's else.
  //   Error: deviation: the root of m (1 - m) (1 + 1 / (L + 1)) for L lines of which a share of m = (V + 1/2) / (L + 1) is facing: no share spreads more about its mean m. Measured:
  //     tests/neighbour_shares_test.cpp.
  Share of(uint32_t i, uint32_t j) const {
    const uint32_t a = ranks_[i] >> kStep, b = ranks_[j] >> kStep;
    return shares_[size_t(std::min(a, b)) * side_ + std::max(a, b)];
  }

 private:
  static constexpr uint32_t kStep = 2;            // bits of a rank from one k to the next
  static constexpr float kEnoughLines = 4;

  std::span<const uint32_t> ranks_;
  size_t side_;
  std::vector<Share> shares_;  // of blocks of 4 x 4 ids
};

}  // namespace viewpeel
