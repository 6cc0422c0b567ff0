// These tests check engine `exact`, which gives exact areas to the estimator.
#include "reference/exact/exact_engine.h"

#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include <viewpeel/error.h>
#include "reference/exact/exact_pair_areas.h"
#include "reference/closed_forms/past_blocker.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/named_scenes.h"

namespace viewpeel::reference {
namespace {

namespace ts = test_scenes;

TEST(ExactEngine, RefusesPolygonsThatPassThroughEachOther) {
  InputScene input{"crossing", {}, {}};
  ts::addFace(input, "table", ts::parallelogram({0, 0, 0}, {2, 0, 0}, {0, 2, 0}));
  ts::addFace(input, "blade", ts::parallelogram({1, 0.5, -1}, {0, 1, 0}, {0, 0, 3}));
  const Scene scene = buildScene(input);
  EXPECT_THROW(makeExactEngine(scene, makeIds(scene, By::polygon, false)), Error);
}

TEST(ExactEngine, EstimatesEqualTheClosedForm) {
  const Scene scene = buildScene(ts::perpendicularSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeExactEngine(scene, ids);
  const Estimate e = estimateFormFactors(*engine, scene, ids, {.directions = 200, .replicates = 16});
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), perpendicularRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}),
                           e.replicates, 1e-11));
  EXPECT_LT(e.largest_standard_error, 1e-3);
}

// Compares form factors past a convex blocker with quadrature.
TEST(ExactEngine, SeesPastABlocker) {
  InputScene input = ts::parallelSquares();
  const std::vector<glm::dvec3> blocker{{0.2, 0.3, 0.4}, {0.9, 0.4, 0.6}, {0.3, 0.8, 0.5}};
  ts::addFace(input, "blocker", blocker);
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const Estimate e =
      estimateFormFactors(*makeExactEngine(scene, ids), scene, ids, {.directions = 200, .replicates = 16});
  const Approximation exact = formFactorPastBlocker(input.faces[0].corners, input.faces[1].corners, blocker);
  EXPECT_TRUE(isEstimateOf(e.form_factors.formFactor(0, 1), exact.value, e.replicates, exact.error));
  EXPECT_GT(e.form_factors.formFactor(1, 2).value + e.form_factors.formFactor(1, kLeak).value,
            0.01);  // the blocker hides something
}

// The region in which the screen is seen has the screen's perimeter. The region of the large square around it has the
// perimeter of both outlines.
TEST(ExactPairAreas, PerimetersMatchTheRegions) {
  InputScene input = ts::parallelSquares();
  ts::addFace(input, "screen",
              {{0.25, 0.25, 0.5}, {0.25, 0.75, 0.5}, {0.75, 0.75, 0.5}, {0.75, 0.25, 0.5}});  // faces down
  const Scene scene = buildScene(input);
  ExactOptions options;
  options.perimeters = true;
  for (const PairArea& pair : computeExactPairAreas(scene, {0, 0, 1}, options).pairs) {
    const bool is_screen = pair.a == 0 && pair.b == 2;
    const double expected = is_screen ? 2 : pair.a == 0 ? 6 : 2;  // the leak of the upper square lies behind the screen
    EXPECT_NEAR(pair.perimeter * scene.scale, expected, 1e-13) << pair.a << " " << pair.b;
    EXPECT_NEAR(pair.area * scene.scale * scene.scale, pair.a == 0 && !is_screen ? 0.75 : 0.25, 1e-13);
  }
}

TEST(ExactEngine, ThreadsNeverChangeTheCounts) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::surface, false);
  const auto directions = sampleDirections(Sampler::fibonacci, 20, 1, 0);
  const PairCounts one = makeExactEngine(scene, ids, {.thread_count = 1})->count(directions),
                   three = makeExactEngine(scene, ids, {.thread_count = 3})->count(directions);
  ASSERT_EQ(one.size(), three.size());
  for (size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k].count, three[k].count);
}

// A screen lies between two larger squares. Lines through it count for a square and the screen, and as blocked for the
// two squares.
TEST(ExactEngine, CountsBlockedPairsOnRequest) {
  InputScene input = ts::parallelSquares();
  ts::addFace(input, "screen",
              {{0.25, 0.25, 0.5}, {0.25, 0.75, 0.5}, {0.75, 0.75, 0.5}, {0.75, 0.25, 0.5}});  // faces down
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::vector<Direction> up = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0}, 3}};
  const auto engine = makeExactEngine(scene, ids, {.blocked = true, .thread_count = 1});
  const double unit = engine->unitArea() * scene.scale * scene.scale;
  const PairCounts counts = engine->count(up), plain = makeExactEngine(scene, ids)->count(up);
  ASSERT_EQ(counts.size(), plain.size());
  for (size_t k = 0; k < counts.size(); ++k) {
    EXPECT_EQ(counts[k].count, plain[k].count);
    EXPECT_EQ(plain[k].blocked, 0u);
    const bool is_pair_of_squares = counts[k].i == 0 && counts[k].j == 1;
    EXPECT_NEAR(double(counts[k].blocked) * unit, is_pair_of_squares ? 3 * 0.25 : 0, 1e-11);
  }
}

}  // namespace
}  // namespace viewpeel::reference
