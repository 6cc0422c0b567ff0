// These tests check that ids are ranked by place, and that pairs with few lines borrow visibility from their
// neighbours.
#include "sums/neighbour_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "estimator/find_prior.h"
#include "reference/closed_forms/past_blocker.h"
#include "scene/rank_by_place.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

Ids namelessIds(uint32_t count) {
  Ids ids;
  ids.names.assign(count, "");
  ids.areas.assign(count, 1);
  ids.surface.assign(count, 0);
  return ids;
}

std::vector<uint32_t> inOrder(uint32_t count) {
  std::vector<uint32_t> ranks(count);
  std::iota(ranks.begin(), ranks.end(), 0u);
  return ranks;
}

// Every rank is given once. Each block of 64 ranks holds one of 64 squares of 8 x 8 parts, on one of the two large
// squares. So ids at other places, or with other normals, are in other blocks.
TEST(RankByPlace, BlocksOfRanksLieTogether) {
  constexpr uint32_t kCuts = 64;
  const Scene scene = buildScene(ts::squaresInParts(kCuts, 1, 10));
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::vector<uint32_t> ranks = rankByPlace(scene, ids.of_polygon, ids.count());
  std::vector<uint32_t> id_of(ids.count(), UINT32_MAX);
  for (uint32_t id = 0; id < ids.count(); ++id) {
    ASSERT_LT(ranks[id], ids.count());
    ASSERT_EQ(id_of[ranks[id]], UINT32_MAX);
    id_of[ranks[id]] = id;
  }
  for (uint32_t first = 0; first < ids.count(); first += 64) {
    const auto placeOf = [&](uint32_t id) { return std::array{id % 2, (id / 2) % kCuts / 8, (id / 2) / kCuts / 8}; };
    for (uint32_t rank = first; rank < first + 64; ++rank) EXPECT_EQ(placeOf(id_of[rank]), placeOf(id_of[first]));
  }
}

// The values of blocks of 4, 16 and 64 ids follow by hand from (19) in docs/method.md. The n lines of one pair count as
// 1.5 n / (n + 0.5), and m = (V + m') / (L + 1) with m' of the next larger blocks. Values are stored in single
// precision, so that 1e-6 is allowed.
TEST(NeighbourVisibility, LinesOfBlocksGoWithLargerBlocks) {
  const Ids ids = namelessIds(64);
  VisibilitySums sums(ids);
  // Of the lines of pair (0, 4) 6 of 8 are facing, of (1, 5) 0 of 1, of (2, 12) 1 of 1, of (2, 30) 1 of 4.
  sums.add(PairCounts{{0, 4, 6, 2}, {1, 5, 0, 1}, {2, 12, 1, 0}, {2, 30, 1, 3}});
  const std::vector<uint32_t> ranks = inOrder(64);
  const NeighbourVisibility shares(sums, {}, ranks);
  const double of_eight = 1.5 * 8 / 8.5, of_four = 1.5 * 4 / 4.5;  // one line counts as 1
  const auto isValue = [&](uint32_t i, uint32_t j, double facing, double all, double mean_around) {
    const NeighbourVisibility::Value visibility = shares.of(i, j);
    EXPECT_NEAR(visibility.mean, (facing + mean_around) / (all + 1), 1e-6) << i << " " << j;
    const double smoothed = (facing + mean_around + 0.1) / (all + 1.2);
    EXPECT_NEAR(visibility.deviation(), std::sqrt(smoothed * (1 - smoothed)), 1e-6) << i << " " << j;
    EXPECT_EQ(shares.of(j, i).mean, visibility.mean);
  };
  // scene is the mean visibility m of all 64 ids. near is m of the blocks of 16 with pairs (0, 4) and (2, 12), and far
  // is m of the blocks with pair (2, 30).
  const double scene = (0.75 * of_eight + 1 + 0.25 * of_four) / (of_eight + 2 + of_four);
  const double near = (0.75 * of_eight + 1 + scene) / (of_eight + 2 + 1),
               far = (0.25 * of_four + scene) / (of_four + 1);
  isValue(3, 5, 0.75 * of_eight, of_eight + 1, near);
  isValue(3, 13, 1, 1, near);
  isValue(6, 9, 0, 0, near);
  isValue(1, 29, 0.25 * of_four, of_four, far);
  isValue(5, 20, 0, 0, far);
  isValue(40, 50, 0, 0, scene);  // no line between ids 32..47 and 48..63
}

// Counts smaller than a line, and lines of one replicate, count as one line for each replicate.
TEST(NeighbourVisibility, LinesThatComeTogetherAreOne) {
  const Ids ids = namelessIds(4);
  VisibilitySums sums(ids);
  sums.add(PairCounts{{0, 1, 30, 0}});  // a whole line would be 100
  sums.add(PairCounts{{0, 1, 0, 30}});
  sums.add(PairCounts{{0, 1, 30, 0}});
  const std::vector<uint32_t> ranks = inOrder(4);
  const NeighbourVisibility shares(sums, {100, 100, 100, 100}, ranks);
  const double three = 1.5 * 3 / 3.5, facing = 2 / 3.0 * three + 2 / 3.0;
  EXPECT_NEAR(shares.of(2, 3).mean, facing / (three + 1), 1e-6);
  const double smoothed = (facing + 0.1) / (three + 1.2);
  EXPECT_NEAR(shares.of(2, 3).deviation(), std::sqrt(smoothed * (1 - smoothed)), 1e-6);
}

// The visibility of a pair with fewer than four lines is averaged with its neighbours', which count as half a line, eq.
// (21). A pair with four lines keeps the visibility of its lines.
TEST(NeighbourVisibility, FewLinesGoWithTheirNeighbours) {
  const Ids ids = namelessIds(4);
  VisibilitySums sums(ids);
  const std::vector<uint32_t> ranks = inOrder(4);
  sums.add(PairCounts{{0, 1, 1, 0}, {1, 3, 0, 2}, {2, 3, 3, 1}});
  sums.add(PairCounts{{0, 2, 1, 1}, {1, 3, 0, 1}});
  const NeighbourVisibility neighbours(sums, {}, ranks);
  const std::vector<PairPrior> prior = {{0, 1, 0, 0, 0.25}, {0, 2, 0, 0, 0.25}, {1, 3, 0, 0, 0.25}, {2, 3, 0, 0, 0.25}};
  const FormFactors shrunk = FormFactors(sums.ids(), sums.find(prior, {}, 1, 1, {}, {}, &neighbours).entries, {}),
                    alone = FormFactors(sums.ids(), sums.find(prior, {}, 1, 1, {}, {}).entries, {});
  ASSERT_EQ(shrunk.entries().size(), 4u);
  const double m = neighbours.of(0, 1).mean;  // all four ids are in one block
  EXPECT_DOUBLE_EQ(shrunk.entries()[0].exchange_area.value, 0.25 * (1 + 0.5 * m) / 1.5);
  EXPECT_DOUBLE_EQ(shrunk.entries()[1].exchange_area.value, 0.25 * (1 + 0.5 * m) / 2.5);
  EXPECT_DOUBLE_EQ(shrunk.entries()[2].exchange_area.value, 0.25 * 0.5 * m / 3.5);
  EXPECT_DOUBLE_EQ(shrunk.entries()[3].exchange_area.value, 0.25 * 0.75);
  EXPECT_DOUBLE_EQ(alone.entries()[0].exchange_area.value, 0.25);
  EXPECT_DOUBLE_EQ(alone.entries()[1].exchange_area.value, 0.125);
}

// Parts of two squares exchange past a blocker. For pairs that no line met, and for pairs that few lines met, the mean
// squared error is at most the stated one. The root is not below a third of the stated one. For pairs that no line met,
// errors are at most half of the errors that values of 0 would have.
TEST(NeighbourVisibility, ErrorsAreAsStated) {
  constexpr uint32_t kCuts = 8;
  InputScene input = ts::squaresInParts(kCuts, 1.0 / kCuts, 1);
  const ts::Corners blocker = ts::squaresPastABlocker().faces.back().corners;
  ts::addFace(input, "blocker", blocker);
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeHostEngine(scene, ids, {.resolution = 16, .count_blocked = true});
  FaceExchanges exchanges(nullptr, scene, ids);
  struct Errors {
    size_t pairs = 0;
    double squares = 0, stated = 0, of_zero = 0;
  };
  Errors unmet, few;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    EstimateOptions options{.directions = 16, .replicates = 4, .seed = seed};
    const FoundPrior found = findPrior(*engine, exchanges, scene, ids, groupAsOne(scene, 16), options,
                                       {choosePriorPilot(options).directions});
    options.prior = &found.prior;
    std::optional<RunSums> sums;
    options.on_sums = [&](const RunSums& so_far, bool last) {
      if (last) sums = so_far;
    };
    estimateFormFactors(*engine, scene, ids, options);
    const FormFactors all = sums->formFactors();
    const auto& counted = sums->prior_sums->byFace().pairs();
    for (const FormFactors::Entry& entry : all.entries()) {
      const bool is_between = entry.i < 2 * kCuts * kCuts && entry.j < 2 * kCuts * kCuts && entry.i % 2 != entry.j % 2;
      const bool has_lines =
          std::ranges::binary_search(counted, std::pair(entry.i, entry.j), {},
                                     [](const VisibilitySums::PairSum& pair) { return std::pair(pair.i, pair.j); });
      Errors& errors = has_lines ? few : unmet;
      if (!is_between || ++errors.pairs % 16) continue;
      const double truth =
          reference::formFactorPastBlocker(input.faces[entry.i].corners, input.faces[entry.j].corners, blocker).value *
          ids.areas[entry.i];
      errors.squares += std::pow(entry.exchange_area.value - truth, 2);
      errors.stated += std::pow(entry.exchange_area.standard_error, 2);
      errors.of_zero += truth * truth;
    }
  }
  for (const Errors& errors : {unmet, few}) {
    EXPECT_GT(errors.pairs, 1000u);
    EXPECT_LT(errors.squares, errors.stated);
    EXPECT_LT(errors.stated, 9 * errors.squares);
  }
  EXPECT_LT(4 * unmet.squares, unmet.of_zero);
}

}  // namespace
}  // namespace viewpeel
