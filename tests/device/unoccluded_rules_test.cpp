// These tests check sides, sums of rows, chunks, and pairs that the library refuses or cannot compute accurately.
// unoccluded_test.cpp says on which devices they run.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "tests/support/unoccluded_pairs.h"

namespace viewpeel {
namespace {

TEST_P(Unoccluded, PairsThatDoNotSeeEachOtherAreExactlyZero) {
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), above = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
  Random random(45);
  std::vector<CornerPair> pairs{
      {square, flipped(above)},
      {flipped(square), above},
      {square, moved(square, 1, {1, 0, 0})},  // coplanar, looking the same way
      {square, moved(square, 0.5, {0.2, 0.2, 0})},
      {square, flipped(moved(square, 1, {1, 0, 0}))},  // coplanar, opposite fronts, with a common edge
      {square, flipped(moved(square, 1, {1.5, 0, 0}))},
      {square, rectangle({0, 0, 0}, {0, 0, 1}, {0, 1, 0})},   // a common edge; the wall looks away
      {square, rectangle({0, 0, -1}, {0, 1, 0}, {0, 0, 1})},  // a common edge; the wall is below
      {square, rectangle({0.5, 0, -2}, {0, 1, 0}, {0, 0, 1})}};
  for (int k = 0; k < 50; ++k) {  // neighbouring faces of a convex solid, turned at random
    const glm::dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())),
                     z = glm::cross(x, y);
    pairs.push_back({rectangle({0, 0, 0}, x, y), rectangle({0, 0, 0}, y, -z)});
  }
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, "unseen");
  for (size_t k = 0; k < pairs.size(); ++k) EXPECT_EQ(outcome.factors[k], 0) << k;
  std::vector<double> areas(1, -1);
  makeExchange(scene).compute(std::vector<SidePair>{{frontSide(0), backSide(0)}}, areas);
  EXPECT_EQ(areas[0], 0) << "a polygon's own sides";
}

TEST_P(Unoccluded, SidesEqualFlippedPolygons) {
  Random random(46);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 40; ++k)
    pairs.push_back({random.convexPolygon(glm::dvec3(0), random.direction(), 3 + k % 2),
                     random.convexPolygon(random.direction() * random.uniform(0.7, 9), random.direction(), 4)});
  const Scene scene = sceneOf(pairs);
  std::vector<SidePair> requested;
  std::vector<double> truths;
  for (uint32_t k = 0; k < scene.polygons.size(); k += 2)
    for (uint32_t back_a : {0u, 1u})
      for (uint32_t back_b : {0u, 1u}) {
        requested.push_back({2 * k + back_a, 2 * (k + 1) + back_b});
        const Corners a = cornersOf(scene, k), b = cornersOf(scene, k + 1);
        truths.push_back(reference::formFactor(back_a ? flipped(a) : a, back_b ? flipped(b) : b));
      }
  std::vector<double> areas(requested.size());
  EXPECT_TRUE(makeExchange(scene).compute(requested, areas).empty());
  for (size_t k = 0; k < requested.size(); ++k) {
    const double area_a = scene.polygons[requested[k].i / 2].area, area_b = scene.polygons[requested[k].j / 2].area;
    // truths[k] is the form factor from a.
    const double allowed =
        std::max(kUnoccludedRelativeError * truths[k] * area_a, kUnoccludedAbsoluteError * std::min(area_a, area_b));
    EXPECT_LE(std::abs(areas[k] - truths[k] * area_a), allowed + reference::kContourError * area_a) << "pair " << k;
  }
}

// In a closed convex room the form factors of every polygon sum to 1, over all classes of pairs at once.
TEST_P(Unoccluded, RoomCloses) {
  constexpr int kCuts = 6;
  Random random(47);
  const glm::dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())), z = glm::cross(x, y);
  InputScene input{"turned room", {"walls"}, {}};
  for (const Corners& face : boxFaces({1, 2, 0.7}))
    for (int i = 0; i < kCuts; ++i)
      for (int j = 0; j < kCuts; ++j) {
        Corners corners;
        for (const auto& [u, v] :
             {std::pair(i, j), std::pair(i + 1, j), std::pair(i + 1, j + 1), std::pair(i, j + 1)}) {
          const glm::dvec3 p =
              face[0] + (face[1] - face[0]) * (double(u) / kCuts) + (face[3] - face[0]) * (double(v) / kCuts);
          corners.push_back(p.x * x + p.y * y + p.z * z);
        }
        input.faces.push_back({corners, 0, 0});
      }
  const Scene scene = buildScene(input);
  const auto n = static_cast<uint32_t>(scene.polygons.size());
  std::vector<SidePair> pairs;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = i; j < n; ++j) pairs.push_back({frontSide(i), frontSide(j)});
  std::vector<double> areas(pairs.size()), sums(n);
  UnoccludedExchange exchange = makeExchange(scene);
  EXPECT_TRUE(exchange.compute(pairs, areas).empty());
  for (size_t k = 0; k < pairs.size(); ++k)
    for (uint32_t side : {pairs[k].i, pairs[k].j}) sums[side / 2] += areas[k];
  // Corners on a cut are rounded alike on both sides. Planes of walls are rounded to 2^-52, which changes a sum by
  // 1e-13.
  for (uint32_t i = 0; i < n; ++i)
    EXPECT_NEAR(sums[i] / scene.polygons[i].area, 1, kUnoccludedRelativeError + n * kUnoccludedAbsoluteError + 1e-12)
        << "polygon " << i;
}

TEST_P(Unoccluded, ChunksDoNotMatter) {
  Random random(48);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 60; ++k) pairs.push_back(randomPair(random, k % 2 ? 3 : 60, 2));
  for (int k = 0; k < 20; ++k) {
    const double angle_rad = random.uniform(0.02, 3.1), length = std::exp(random.uniform(-4, 4));
    pairs.push_back({rectangle({0, 0, 0}, {0, 0, length}, {1, 0, 0}),
                     rectangle({0, 0, 0}, {std::cos(angle_rad), std::sin(angle_rad), 0}, {0, 0, length})});
  }
  const Scene scene = sceneOf(pairs);
  std::vector<SidePair> requested;
  for (uint32_t k = 0; k < scene.polygons.size(); k += 2) requested.push_back({frontSide(k), frontSide(k + 1)});
  std::vector<double> whole(requested.size()), parts(requested.size());
  UnoccludedExchange large = makeExchange(scene);
  UnoccludedExchange small = makeExchange(scene, {.chunk_pairs = 11, .near_pairs = 3, .thread_count = 3});
  large.compute(requested, whole);
  small.compute(requested, parts);
  EXPECT_EQ(whole, parts);
  EXPECT_EQ(large.work().near_pairs, small.work().near_pairs);
  EXPECT_GT(small.work().again_pairs, 0u);
  EXPECT_GT(small.work().far_pairs[1], 0u);
}

// These strips are so thin that rounding alone exceeds the allowed error. The value is computed, and the pair is
// reported.
TEST_P(Unoccluded, ReportsWhatItCannotReach) {
  constexpr double kWidth = 1e-10;
  const Scene scene =
      sceneOf({{rectangle({0, 0, 0}, {kWidth, 0, 0}, {0, 1, 0}), rectangle({0, 0, 0.1}, {0, 1, 0}, {1, 0, 0})},
               {rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 0.1}, {0, 1, 0}, {1, 0, 0})}});
  std::vector<double> areas(2);
  const std::vector<UnreachedPair> unreached =
      makeExchange(scene, {.chunk_pairs = 1})
          .compute(std::vector<SidePair>{{frontSide(2), frontSide(3)}, {frontSide(0), frontSide(1)}}, areas);
  ASSERT_EQ(unreached.size(), 1u);
  EXPECT_EQ(unreached[0].pair, 1u);
  EXPECT_GT(unreached[0].error, kUnoccludedRelativeError * areas[1]);
  const double truth = scene.polygons[0].area * reference::parallelRectangles({0, kWidth}, {0, 1}, {0, 1}, {0, 1}, 0.1);
  EXPECT_LE(std::abs(areas[1] - truth), unreached[0].error);
}

TEST_P(Unoccluded, RefusesWhatIsNotThere) {
  const Scene scene =
      sceneOf({{rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0})}});
  UnoccludedExchange exchange = makeExchange(scene);
  std::vector<double> areas(1);
  EXPECT_THROW(exchange.compute(std::vector<SidePair>{{0, 4}}, areas), Error);
  EXPECT_THROW(exchange.compute(std::vector<SidePair>{{0, 2}, {2, 0}}, areas), Error);
  EXPECT_TRUE(exchange.compute({}, {}).empty());
}

// Negative control: isAccurate() refuses wrong values.
TEST_P(Unoccluded, WrongValuesAreNoticed) {
  EXPECT_TRUE(isAccurate(0.25, 0.25 * (1 + 9e-7), 0));
  EXPECT_FALSE(isAccurate(0.25, 0.25 * (1 + 1.1e-6), 0));
  EXPECT_FALSE(isAccurate(0, 1.1e-9, 0));
}

}  // namespace
}  // namespace viewpeel
