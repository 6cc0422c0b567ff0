// Closed forms times visible shares: exact where nothing is in between, honest where something is.
#include <cmath>
#include <random>

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include "compare.h"
#include "estimator/visible_share.h"
#include "reference/past_blocker.h"
#include "scenes.h"
#include "test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kParallelSquares = 0.1998248957, kPerpendicularSquares = 0.2000437761, kTenDigits = 5e-11;

struct Shared {
  Scene scene;
  Ids ids;
  std::unique_ptr<Engine> engine;
  Estimate estimate(const EstimateOptions& options, By by = By::polygon) const {
    return estimateVisibleShares(*engine, scene, ids, by, options, findVisibleShares(*engine, testDevice(), scene, ids, options));
  }
};

Shared share(const InputScene& input, int resolution, bool two_sided = false) {
  Shared made{buildScene(input), {}, nullptr};
  made.ids = makeIds(made.scene, By::polygon, two_sided);
  made.engine = makeComputeEngine(testDevice(), made.scene, made.ids, {.resolution = resolution, .count_blocked = true});
  return made;
}

TEST(ControlSums, WithoutSharesTheyAreReplicateSums) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeComputeEngine(testDevice(), scene, ids, {.resolution = 24, .count_blocked = true});
  ReplicateSums plain(ids);
  ControlSums controls(ids);
  for (uint64_t r = 0; r < 5; ++r) {
    const PairCounts counts = engine->count(sampleDirections(Sampler::fibonacci, 20, 1, r));
    plain.add(counts);
    controls.add(takeShares(counts, {}));
  }
  const FormFactors a = plain.formFactors(0.01), b = controls.formFactors(0.01, {});
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].i, b.entries()[k].i);
    EXPECT_EQ(a.entries()[k].j, b.entries()[k].j);
    // Rounding: a dozen operations in double on one side, in long double on the other.
    EXPECT_NEAR(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value, 1e-14 * a.entries()[k].exchange_area.value);
    EXPECT_NEAR(a.entries()[k].exchange_area.standard_error, b.entries()[k].exchange_area.standard_error, 1e-12 * a.entries()[k].exchange_area.standard_error);
  }
}

TEST(ControlSums, ByHand) {
  const std::vector<PairShare> shares{{0, 1, kShareOne / 4}};
  const PairCounts first{{0, 1, 3, 5}, {0, 2, 2}, {0, kEnvironment, 7}}, second{{0, 1, 1, 11}};
  const auto controls = takeShares(first, shares);
  ASSERT_EQ(controls.size(), 3u);
  EXPECT_EQ(controls[0].control, (3 - 0.25 * 8) * kShareOne);
  EXPECT_EQ(controls[0].squares, ControlCount::Wide((3 * 0.5625 + 5 * 0.0625) * kShareOne * kShareOne));
  EXPECT_EQ(controls[1].control, 2 * kShareOne);
  EXPECT_EQ(controls[2].control, 7 * kShareOne);
  const auto merged = mergeIds(controls, {0, 1, 1});
  ASSERT_EQ(merged.size(), 2u);
  EXPECT_EQ(merged[0].control, 3 * kShareOne);

  Ids ids;
  ids.names = {"a", "b", "c"};
  ids.areas = {1, 1, 1};
  ControlSums sums(ids);
  sums.add(controls);
  sums.add(takeShares(second, shares));
  // Controls of (0, 1): 1 and -2, mean -0.5; variance of the sum 2 x 4.5 = 9; squares 2 + 1.25 lines, so 9 / 3.25 lines at a time.
  const Measured f = sums.formFactors(0.5, {{0, 1, 4, 16}}).exchangeArea(0, 1);
  EXPECT_DOUBLE_EQ(f.value, 3.5);
  EXPECT_DOUBLE_EQ(f.standard_error, std::sqrt(9 + 9 / 3.25 * 9 / 3.25) / 2);
  // What is visible is not less than nothing, nor more than all.
  EXPECT_EQ(sums.formFactors(0.5, {{0, 1, 0.25, 16}}).exchangeArea(0, 1).value, 0);
  EXPECT_EQ(sums.formFactors(0.5, {{0, 1, 17, 16}}).exchangeArea(0, 1).value, 16);
  // A pair known and never met is there, with one line's standard error.
  const Measured unmet = sums.formFactors(0.5, {{1, 2, 4, 4}}).exchangeArea(1, 2);
  EXPECT_EQ(unmet.value, 4);
  EXPECT_EQ(unmet.standard_error, 0.5);
}

// Pairs never blocked are their closed forms, on any lattice and with any number of directions.
TEST(VisibleShare, UnblockedPairsAreExact) {
  for (const auto& [input, truth] : {std::pair(ts::parallelSquares(), kParallelSquares), std::pair(ts::perpendicularSquares(), kPerpendicularSquares)}) {
    const Estimate e = share(input, 16).estimate({.directions = 24, .replicates = 4});
    EXPECT_NEAR(e.form_factors.formFactor(0, 1).value, truth, kUnoccludedRelativeError * truth + kTenDigits);
    EXPECT_EQ(e.form_factors.exchangeArea(0, 1).value, e.form_factors.exchangeArea(1, 0).value);
    EXPECT_GT(e.form_factors.formFactor(0, 1).standard_error, 0);  // one line's: nothing says that no blocker is there
  }
  const Estimate cube = share(ts::insideOfCube(), 16).estimate({.directions = 24, .replicates = 4});
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = 0; j < 6; ++j) {
      const double truth = i == j ? 0 : i / 2 == j / 2 ? kParallelSquares : kPerpendicularSquares;
      EXPECT_NEAR(cube.form_factors.formFactor(i, j).value, truth, kUnoccludedRelativeError * truth + kTenDigits);
    }
}

InputScene squaresPastABlocker() {
  InputScene input = ts::parallelSquares();
  ts::addFace(input, "blocker", {{0.2, 0.1, 0.4}, {0.7, 0.1, 0.4}, {0.7, 0.6, 0.4}, {0.2, 0.6, 0.4}});
  return input;
}

double truthPastTheBlocker() {
  const InputScene input = squaresPastABlocker();
  return reference::formFactorPastBlocker(input.faces[0].corners, input.faces[1].corners, input.faces[2].corners).value;
}

// Partly blocked: unbiased, with less error than counting alone, and 95 % intervals that hold the truth 95 times in 100 but for chance, that is within four
// standard deviations of the binomial law.
TEST(VisibleShare, PartlyBlockedPairsAreSampledWell) {
  const Shared made = share(squaresPastABlocker(), 24);
  const double truth = truthPastTheBlocker();
  constexpr int kSeeds = 60;
  const double t = quantile(complement(boost::math::students_t(7), 0.025));
  double squares = 0, plain_squares = 0, sum = 0;
  int held = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const EstimateOptions options{.directions = 64, .seed = seed};
    const Measured f = made.estimate(options).form_factors.formFactor(0, 1);
    const double plain = estimateFormFactors(*made.engine, made.scene, made.ids, options).form_factors.formFactor(0, 1).value;
    held += std::abs(f.value - truth) <= t * f.standard_error;
    sum += f.value - truth;
    squares += std::pow(f.value - truth, 2);
    plain_squares += std::pow(plain - truth, 2);
  }
  EXPECT_LE(std::abs(held - 0.95 * kSeeds), 4 * std::sqrt(0.95 * 0.05 * kSeeds));
  EXPECT_LE(std::abs(sum / kSeeds), 5 * std::sqrt(squares) / kSeeds);
  // Of one variance, F(60, 60) stays below 2.3 with probability 0.999: it is smaller indeed.
  EXPECT_LT(2.3 * squares, plain_squares);
}

// The same lines in another sum: form factors between surfaces are what those of their polygons add up to, and agree with counting alone.
TEST(VisibleShare, SurfacesAndClosedRooms) {
  const Shared made = share(ts::roomWithTouchingBoxes(), 48);
  const EstimateOptions options{.directions = 400};
  const Estimate by_surface = made.estimate(options, By::surface), plain = estimateFormFactors(*made.engine, made.scene, made.ids, options);
  const uint32_t n = by_surface.form_factors.ids().count();
  EXPECT_EQ(n, makeIds(made.scene, By::surface, false).count());
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j)
      EXPECT_TRUE(areEstimatesOfTheSame(by_surface.form_factors.formFactor(i, j), plain.between_surfaces.formFactor(i, j), options.replicates)) << i << " " << j;
  const Estimate by_polygon = made.estimate(options);
  for (const auto& entry : by_polygon.form_factors.entries()) {
    const auto& areas = made.ids.areas;
    EXPECT_GE(entry.exchange_area.value, 0);
    EXPECT_LE(entry.exchange_area.value, entry.j < kEnvironment ? std::min(areas[entry.i], areas[entry.j]) : INFINITY);
    EXPECT_TRUE(areEstimatesOfTheSame(by_polygon.form_factors.formFactor(entry.i, entry.j), plain.form_factors.formFactor(entry.i, entry.j), options.replicates));
  }
  EXPECT_LT(by_polygon.largest_standard_error, plain.largest_standard_error);
}

}  // namespace
}  // namespace viewpeel
