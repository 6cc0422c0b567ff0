#include "matrix/neighbour_shares.h"

#include <algorithm>
#include <cmath>

namespace viewpeel {
namespace {

float smoothed(float facing, float all) { return (facing + 0.5f) / (all + 1); }

}  // namespace

NeighbourShares::NeighbourShares(const ShareSums& sums, const std::vector<uint64_t>& lines, const std::vector<uint32_t>& ranks)
    : ranks_(ranks), side_(((ranks.size() - 1) >> kStep) + 1), shares_(side_ * side_) {
  std::vector<Level> levels{{kStep, side_, std::vector<Lines>(side_ * side_)}};
  for (const ShareSums::PairSum& pair : sums.pairs()) {
    if (pair.j >= kEnvironment || pair.i == pair.j || pair.facing + pair.blocked == 0) continue;
    // Lines of a replicate that come as one, or parts of lines, count as the replicates do (Kish, Survey Sampling, 1965, section 8.2).
    const double all = double(pair.facing) + double(pair.blocked), squares = double(pair.facing_squared) + 2 * double(pair.product) + double(pair.blocked_squared);
    const double lines_told = std::max(all / double(lineOf(lines, pair.i, pair.j)), all * all / squares);
    const auto [a, b] = std::minmax({ranks[pair.i] >> kStep, ranks[pair.j] >> kStep});
    Lines& block = levels[0].blocks[a * side_ + b];
    block.facing += static_cast<float>(lines_told * double(pair.facing) / all);
    block.all += static_cast<float>(lines_told);
  }
  while (levels.back().side > 1) {
    const Level& fine = levels.back();
    const size_t side = ((fine.side - 1) >> kStep) + 1;
    Level coarse{fine.shift + kStep, side, std::vector<Lines>(side * side)};
    for (size_t a = 0; a < fine.side; ++a)
      for (size_t b = a; b < fine.side; ++b) {
        Lines& block = coarse.blocks[(a >> kStep) * side + (b >> kStep)];
        block.facing += fine.blocks[a * fine.side + b].facing;
        block.all += fine.blocks[a * fine.side + b].all;
      }
    levels.push_back(std::move(coarse));
  }
  for (uint32_t a = 0; a < side_; ++a)
    for (uint32_t b = a; b < side_; ++b) {
      const auto [facing, all] = linesOf(levels, a << kStep, b << kStep, kEnoughLines);
      const float mean = (facing + 1) / (all + 2);
      shares_[a * side_ + b] = {all > 0 ? facing / all : 0.5f, std::sqrt(mean * (1 - mean) * (1 + 1 / (all + 1)))};
    }
  if (levels.size() > 1) levels.erase(levels.begin());
  coarse_ = std::move(levels);
}

NeighbourShares::Lines NeighbourShares::linesOf(std::span<const Level> levels, uint32_t rank_a, uint32_t rank_b, float enough) {
  const auto at = [&](const Level& level) { return level.blocks[(rank_a >> level.shift) * level.side + (rank_b >> level.shift)]; };
  while (levels.size() > 1 && at(levels.front()).all < enough) levels = levels.subspan(1);
  return at(levels.front());
}

float NeighbourShares::around(uint32_t i, uint32_t j, float enough) const {
  const Lines lines = linesOf(coarse_, std::min(ranks_[i], ranks_[j]), std::max(ranks_[i], ranks_[j]), enough);
  return smoothed(lines.facing, lines.all);
}

}  // namespace viewpeel
