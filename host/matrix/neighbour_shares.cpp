#include "matrix/neighbour_shares.h"

#include <algorithm>
#include <cmath>

namespace viewpeel {
namespace {

struct Lines {
  float facing = 0, all = 0;
};

// Of square blocks of ids; those below the diagonal are empty.
struct Level {
  size_t side;
  std::vector<Lines> blocks;
};

}  // namespace

NeighbourShares::NeighbourShares(const ShareSums& sums, const std::vector<uint64_t>& lines, const std::vector<uint32_t>& ranks)
    : ranks_(ranks), side_(((ranks.size() - 1) >> kStep) + 1), shares_(side_ * side_) {
  std::vector<Level> levels{{side_, std::vector<Lines>(side_ * side_)}};
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
    Level coarse{side, std::vector<Lines>(side * side)};
    for (size_t a = 0; a < fine.side; ++a)
      for (size_t b = a; b < fine.side; ++b) {
        Lines& block = coarse.blocks[(a >> kStep) * side + (b >> kStep)];
        block.facing += fine.blocks[a * fine.side + b].facing;
        block.all += fine.blocks[a * fine.side + b].all;
      }
    levels.push_back(std::move(coarse));
  }
  for (size_t a = 0; a < side_; ++a)
    for (size_t b = a; b < side_; ++b) {
      size_t level = 0;
      const auto linesOf = [&] { return levels[level].blocks[(a >> (kStep * level)) * levels[level].side + (b >> (kStep * level))]; };
      while (level + 1 < levels.size() && linesOf().all < kEnoughLines) ++level;
      const auto [facing, all] = linesOf();
      const float smoothed = (facing + 0.5f) / (all + 1);
      shares_[a * side_ + b] = {all > 0 ? facing / all : 0.5f, std::sqrt(smoothed * (1 - smoothed) * (1 + 1 / (all + 1)))};
    }
}

}  // namespace viewpeel
