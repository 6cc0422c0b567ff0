#include "sums/neighbour_visibility.h"

#include <utility>

namespace viewpeel {
namespace {

// A tenth of a facing and of a blocked line are added in s of eq. (20). As measured, 95 % intervals then hold the truth
// in 95 to 97 % of cases.
constexpr float kBeside = 0.1f;

// Lines are the weighted numbers of facing lines, V, and of all lines, L, in eq. (19).
struct Lines {
  float facing = 0, all = 0;
};

// A Level divides ranks into `side` groups. The block at a * side + b holds the lines between the ids of groups a and
// b >= a; blocks with b < a stay empty.
struct Level {
  size_t side;
  std::vector<Lines> blocks;
};

}  // namespace

NeighbourVisibility::NeighbourVisibility(const VisibilitySums& sums, const std::vector<uint64_t>& lines,
                                         const std::vector<uint32_t>& ranks)
    : ranks_(ranks), side_(((ranks.size() - 1) >> kStep) + 1), visibilities_(side_ * side_) {
  std::vector<Level> levels{{side_, std::vector<Lines>(side_ * side_)}};
  for (const VisibilitySums::PairSum& pair : sums.pairs()) {
    if (pair.j >= kEnvironment || pair.i == pair.j || pair.facing + pair.blocked == 0) continue;
    const double all = double(pair.facing) + double(pair.blocked),
                 effective = effectiveLines(pair, sums.squaresOf(pair), double(lineOf(lines, pair.i, pair.j)));
    const double weight = (1 + kNeighbours) * effective / (effective + kNeighbours),
                 visibility = double(pair.facing) / all;  // exactly 1 where all lines are facing
    Lines& block = levels[0].blocks[blockOf(ranks[pair.i], ranks[pair.j])];
    block.facing += static_cast<float>(weight * visibility);
    block.all += static_cast<float>(weight);
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
  const Lines& scene = levels.back().blocks[0];
  // `means` holds the visibilities m of the blocks of the next coarser level, at first of the whole scene.
  std::vector<float> means{scene.all > 0 ? scene.facing / scene.all : 0.5f};
  for (size_t k = levels.size(); k-- > 0;) {
    const auto& [side, blocks] = levels[k];
    const size_t coarse_side = ((side - 1) >> kStep) + 1;
    std::vector<float> finer(k > 0 ? side * side : 0);
    for (size_t a = 0; a < side; ++a)
      for (size_t b = a; b < side; ++b) {
        const Lines& of = blocks[a * side + b];
        const float facing = of.facing + means[(a >> kStep) * coarse_side + (b >> kStep)], mean = facing / (of.all + 1),
                    smoothed = (facing + kBeside) / (of.all + 1 + 2 * kBeside);
        if (k > 0) finer[a * side + b] = mean;
        else visibilities_[a * side + b] = {mean, smoothed};
      }
    means = std::move(finer);
  }
}

}  // namespace viewpeel
