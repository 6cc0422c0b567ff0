// Ranks by place, and the shares of neighbours.
#include "matrix/neighbour_shares.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "engines/host_engine.h"
#include "estimator/estimate.h"
#include "estimator/visible_share.h"
#include "reference/past_blocker.h"
#include "scene/rank_by_place.h"
#include "scenes.h"

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

// Every rank is given once, and the 64 ids of any block of ranks lie in one of 64 squares of 8 x 8 parts, or their mirror images above: those of other places or directions come elsewhere.
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

// Of 64 ids in order, lines between the first four and the next four tell of those, few lines beside them of the 16 around, and the rest of the scene of what no line met.
TEST(NeighbourShares, TheLeastBlockWithEnoughLinesTells) {
  const Ids ids = namelessIds(64);
  ShareSums sums(ids);
  // (0, 4): 6 of 8 lines facing; (1, 17): 1 of 1; (2, 30): 1 of 4.
  sums.add(PairCounts{{0, 4, 6, 2}, {1, 17, 1, 0}, {2, 30, 1, 3}});
  const std::vector<uint32_t> ranks = inOrder(64);
  const NeighbourShares shares(sums, {}, ranks);
  const auto isShare = [&](uint32_t i, uint32_t j, float facing, float all) {
    const NeighbourShares::Share share = shares.of(i, j);
    EXPECT_FLOAT_EQ(share.mean, facing / all) << i << " " << j;
    const float smoothed = (facing + 1) / (all + 2);
    EXPECT_FLOAT_EQ(share.deviation, std::sqrt(smoothed * (1 - smoothed) * (1 + 1 / (all + 1)))) << i << " " << j;
    EXPECT_EQ(shares.of(j, i).mean, share.mean);
  };
  isShare(3, 5, 6, 8);
  isShare(0, 16, 2, 5);   // one line is too few: all between 0..15 and 16..31
  isShare(15, 31, 2, 5);
  isShare(2, 28, 1, 4);
  isShare(40, 50, 8, 13);
  // With 16 ids around each, as many lines as are enough, a half of one and its opposite beside.
  EXPECT_FLOAT_EQ(shares.around(3, 5, 1), 6.5f / 9);
  EXPECT_FLOAT_EQ(shares.around(0, 16, 5), 2.5f / 6);
  EXPECT_FLOAT_EQ(shares.around(30, 2, 6), 8.5f / 14);
}

// Parts of lines, and lines that come together, count as the replicates that they come from.
TEST(NeighbourShares, LinesThatComeTogetherAreOne) {
  const Ids ids = namelessIds(4);
  ShareSums sums(ids);
  sums.add(PairCounts{{0, 1, 30, 0}});  // less than a line
  sums.add(PairCounts{{0, 1, 0, 30}});
  sums.add(PairCounts{{0, 1, 30, 0}});
  const std::vector<uint32_t> ranks = inOrder(4);
  const NeighbourShares shares(sums, {100, 100, 100, 100}, ranks);
  EXPECT_FLOAT_EQ(shares.of(2, 3).mean, 2 / 3.0f);
  const float smoothed = 3.0f / 5;
  EXPECT_FLOAT_EQ(shares.of(2, 3).deviation, std::sqrt(smoothed * (1 - smoothed) * (1 + 1 / 4.0f)));
}

// Parts of two squares past a blocker: over pairs that no line met, and over those of which few told, errors are no larger than stated, in the mean of squares, nor less than a third; and those of
// pairs that no line met are half of what taking them for 0 would make, or less.
TEST(NeighbourShares, ErrorsAreAsStated) {
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
    const VisibleShares found =
        findVisibleShares(*engine, exchanges, scene, ids, groupAsOne(scene, 16), options, pilotDirections(options));
    options.known = &found.known;
    std::optional<RunSums> sums;
    options.on_sums = [&](const RunSums& so_far, bool last) {
      if (last) sums = so_far;
    };
    estimateFormFactors(*engine, scene, ids, options);
    const FormFactors all = sums->formFactors();
    const auto& told = sums->visible->byFace().pairs();
    for (const FormFactors::Entry& entry : all.entries()) {
      const bool is_between = entry.i < 2 * kCuts * kCuts && entry.j < 2 * kCuts * kCuts && entry.i % 2 != entry.j % 2;
      const bool is_told = std::ranges::binary_search(told, std::pair(entry.i, entry.j), {}, [](const ShareSums::PairSum& pair) { return std::pair(pair.i, pair.j); });
      Errors& errors = is_told ? few : unmet;
      if (!is_between || ++errors.pairs % 128) continue;
      const double truth = reference::formFactorPastBlocker(input.faces[entry.i].corners, input.faces[entry.j].corners, blocker).value * ids.areas[entry.i];
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
