// These tests compare the environment above and below a horizon with closed forms, alone and in heat.
#include <numbers>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/environment.h>
#include <viewpeel/error.h>

#include "estimator/environment_rays.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"
#include "stopwatch.h"
#include "tests/support/enclosures.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;
namespace ts = test_scenes;
using reference::test::isEstimateOf;
using reference::test::isWithin;

// Returns a square whose normal is `tilt_rad` away from straight up.
InputScene tiltedSquare(double tilt_rad) {
  InputScene scene{"tilted square", {}, {}};
  ts::addFace(scene, "square", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, std::cos(tilt_rad), -std::sin(tilt_rad)}));
  return scene;
}

// A plate sees the share (1 + cos t) / 2 of its half sphere above the horizon. Chance exceeds 4.5 standard errors of
// eight replicates, t of 7 degrees of freedom, once in 360 comparisons; the seed is fixed.
TEST(Environment, OfATiltedPlate) {
  for (const double tilt : {0.0, 0.3, 1.2, std::numbers::pi / 2, 2.0, std::numbers::pi}) {
    SCOPED_TRACE(tilt);
    const Scene scene = buildScene(tiltedSquare(tilt));
    const EnvironmentParts parts = measureEnvironment(scene, {});
    const double truth = (1 + std::cos(tilt)) / 2;
    EXPECT_TRUE(parts.is_reached);
    EXPECT_LE(parts.largest_standard_error, 1e-3);
    EXPECT_TRUE(isEstimateOf(parts.up[0].value, parts.up[0].standard_error, truth));
    EXPECT_TRUE(isEstimateOf(parts.down[0].value, parts.down[0].standard_error, 1 - truth));
    EXPECT_TRUE(isEstimateOf(parts.up_share[0].value, parts.up_share[0].standard_error, truth));
    EXPECT_FALSE(isEstimateOf(parts.up[0].value, parts.up[0].standard_error, truth + 0.01));  // negative control
  }
  // With another upward direction the parts change, and both sides of the plate together see equal parts.
  const Scene scene = buildScene(tiltedSquare(0));
  const EnvironmentParts side = measureEnvironment(scene, {.up = {0, 5, 0}});
  EXPECT_TRUE(isEstimateOf(side.up[0].value, side.up[0].standard_error, 0.5));
  const EnvironmentParts both = measureEnvironment(scene, {.two_sided = true});
  EXPECT_TRUE(isEstimateOf(both.up[0].value, both.up[0].standard_error, 0.5));
  EXPECT_TRUE(isEstimateOf(both.down[0].value, both.down[0].standard_error, 0.5));
}

// One square faces another above it: radiation that passes the other goes up. Rows of several surfaces have sums of the
// parts.
TEST(Environment, PastAnotherPlate) {
  const Scene scene = buildScene(ts::parallelSquares());
  const double between = reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1);
  const EnvironmentParts parts = measureEnvironment(scene, {.by = By::surface, .tolerance = 3e-4});
  EXPECT_LE(parts.largest_standard_error, 3e-4);
  EXPECT_TRUE(isEstimateOf(parts.up[0].value, parts.up[0].standard_error, 1 - between));
  EXPECT_EQ(parts.down[0].value, 0);
  EXPECT_TRUE(isEstimateOf(parts.down[1].value, parts.down[1].standard_error, 1 - between));
  EXPECT_EQ(parts.up[1].value, 0);
}

// Returns a box and a tilted plate above a floor.    In: crosses: whether the box's top stands out of the plate
InputScene boxAndPlate(bool crosses = false) {
  InputScene scene{"box and plate", {}, {}};
  ts::addFace(scene, "floor", ts::parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}));
  ts::addBox(scene, "box", {-1, -0.5, 0.1}, {-0.2, 0.5, 1}, false);
  const ts::Corners past = ts::parallelogram({0.2, -1, 0.3}, {1, 0, 0.8}, {0, 1.5, 0}),
                    around = ts::parallelogram({-1.5, -1, 0.85}, {2, 0, 0.1}, {0, 2, 0});
  ts::addFace(scene, "plate", crosses ? around : past);
  return scene;
}

// The two parts add up to the environment in a run of all form factors, also where scanlines could not order polygons.
TEST(Environment, AddsUpToThatOfAllFormFactors) {
  for (const bool crosses : {false, true}) {
    SCOPED_TRACE(crosses);
    const Scene scene = buildScene(boxAndPlate(crosses));
    const EnvironmentParts parts = measureEnvironment(scene, {.tolerance = 2e-3});
    const Result all = computeFormFactors(
        scene,
        {.two_sided = false, .goal = Tolerance{2e-3}, .pair_lines = false, .seed = 7, .engine = EngineKind::host});
    double squares = 0;
    for (uint32_t i = 0; i < parts.ids.count(); ++i) {
      const Measured truth = all.form_factors.formFactor(i, kEnvironment);
      const double error = std::hypot(parts.all[i].standard_error, truth.standard_error);
      squares += std::pow((parts.all[i].value - truth.value) / error, 2);
      EXPECT_TRUE(isWithin(parts.all[i].value, parts.up[i].value + parts.down[i].value, 1e-14));
    }
    // Errors of rows follow Student's t of 7 degrees of freedom at worst, with a variance of 7/5. Rows have directions
    // in common, so that the mean over rows spreads: twice as much is allowed, and the seeds are fixed.
    EXPECT_LE(squares / parts.ids.count(), 2.8);
  }
}

// A guarantee gives intervals to the parts above and below the horizon, too. They hold a fine measurement of the same
// parts, within 6 of its standard errors: a false alarm once in 1e8 rows.
TEST(Environment, PartsOfAGuaranteeHaveIntervals) {
  const Scene scene = buildScene(boxAndPlate());
  const Result all = computeFormFactors(scene, {.goal = EpsilonDelta{.epsilon = 1e-2, .rows = true}});
  const EnvironmentParts truth = measureEnvironment(scene, {.tolerance = 2e-4}),
                         parts = splitEnvironment(all.form_factors, measureEnvironment(scene, {.tolerance = 1e-2}));
  ASSERT_EQ(parts.up_intervals.size(), parts.ids.count());
  EXPECT_TRUE(truth.up_intervals.empty());
  const auto isInside = [](const Interval& interval, const Measured& part) {
    return part.value >= interval.lower - 6 * part.standard_error &&
           part.value <= interval.upper + 6 * part.standard_error;
  };
  bool may_fail = false;
  for (uint32_t i = 0; i < parts.ids.count(); ++i) {
    SCOPED_TRACE(parts.ids.names[i]);
    for (const auto& [interval, part, fine] : {std::tuple(parts.up_intervals[i], parts.up[i], truth.up[i]),
                                               std::tuple(parts.down_intervals[i], parts.down[i], truth.down[i])}) {
      EXPECT_TRUE(isInside(interval, fine)) << fine.value << " in " << interval.lower << " to " << interval.upper;
      EXPECT_GE(part.value, interval.lower);
      EXPECT_LE(part.value, interval.upper);
      // Negative control: a part that is off by half a row's radiation is outside.
      may_fail |= !isInside(interval, {fine.value + 0.5, fine.standard_error});
    }
  }
  EXPECT_TRUE(may_fail);
  // What is level sees one side of the horizon alone, so that its part is as narrow as the environment.
  const Interval floor = all.form_factors.interval(0, kEnvironment);
  EXPECT_NEAR(parts.up_intervals[0].lower, floor.lower, 2e-6);
  EXPECT_NEAR(parts.up_intervals[0].upper, floor.upper, 2e-6);
  EXPECT_LE(parts.down_intervals[0].upper, 2e-6);
}

TEST(Environment, ThreadsDoNotMatterAndTheSeedDoes) {
  const Scene scene = buildScene(ts::triangleSoup(10, 0.5, 3));
  const auto upOf = [&](uint64_t seed, uint32_t threads) {
    return measureEnvironment(scene, {.tolerance = 0.01, .seed = seed, .threads = threads}).up.front().value;
  };
  EXPECT_EQ(upOf(1, 1), upOf(1, 3));
  EXPECT_NE(upOf(1, 1), upOf(2, 1));
  EXPECT_THROW(measureEnvironment(scene, {.up = {0, 0, 0}}), Error);
  EXPECT_THROW(measureEnvironment(scene, {.tolerance = 0}), Error);
  EXPECT_THROW(measureEnvironment(scene, {}, {.should_stop = [] { return true; }}), Error);
}

// Returns a floor, and small plates over it of all tilts. The plates are level with each other, and far apart beside
// their size, so that each one sees the floor, or the sky.
InputScene smallPlatesOverAFloor(uint32_t plates) {
  InputScene scene{"small plates over a floor", {}, {}};
  ts::addFace(scene, "floor", ts::parallelogram({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}));
  for (uint32_t k = 0; k < plates; ++k) {
    const double tilt = std::numbers::pi * k / plates, x = -10 + 20.0 * k / plates, size = 0.01;
    ts::addFace(scene, "plate" + std::to_string(k),
                ts::parallelogram({x, 0, 0.5}, {0, size, 0}, {-size * std::cos(tilt), 0, size * std::sin(tilt)}));
  }
  return scene;
}

// Common directions hardly meet the plates, which get rays of their own. A plate of tilt t sees the sky by
// (1 + cos t) / 2. Past the rim of the floor it also sees a strip below the horizon. The plates are 0.5 above a floor
// that goes on for 40 at least, so the strip is at most atan(0.5 / 40) / 2 = 0.0062. Errors of eight replicates follow
// Student's t of 7 degrees of freedom, or have less spread where they were made larger: the mean of z^2 over 64 plates
// is below 7/5 + 4 sqrt(2 (7/5)^2 5 / 64) = 3.6.
//
// The rays are quick ones, in single precision.
TEST(Environment, RowsThatDirectionsHardlyMeetHaveRays) {
  constexpr uint32_t kPlates = 64;
  const Scene scene = buildScene(smallPlatesOverAFloor(kPlates));
  const EnvironmentParts parts = measureEnvironment(scene, {.tolerance = 3e-3});
  EXPECT_TRUE(parts.is_reached);
  EXPECT_LE(parts.largest_standard_error, 3e-3);
  EXPECT_GT(parts.rows_with_rays, kPlates / 2);
  EXPECT_GE(parts.rays, 8 * 64 * parts.rows_with_rays);
  double squares = 0, shifted = 0;
  for (uint32_t k = 0; k < kPlates; ++k) {
    const double truth = (1 + std::cos(std::numbers::pi * k / kPlates)) / 2;
    const Measured& up = parts.up[k + 1];
    ASSERT_GT(up.standard_error, 0) << k;
    squares += std::pow((up.value - truth) / up.standard_error, 2);
    shifted += std::pow((up.value - truth - 0.02) / up.standard_error, 2);
    EXPECT_LE(parts.down[k + 1].value, 0.0062 + 5 * parts.down[k + 1].standard_error) << k;
    double errors = 0;
    for (const auto& replicate : parts.up_share_errors) errors += std::pow(replicate[k + 1], 2);
    EXPECT_TRUE(isWithin(std::sqrt(errors), parts.up_share[k + 1].standard_error, 1e-12)) << k;
  }
  EXPECT_LT(squares / kPlates, 3.6);
  EXPECT_GT(shifted / kPlates, 3.6);  // negative control
  // Threads do not matter, the seed does, and both sides of a plate see half of the sky each.
  EXPECT_EQ(measureEnvironment(scene, {.tolerance = 3e-3, .threads = 3}).up.back().value, parts.up.back().value);
  EXPECT_NE(measureEnvironment(scene, {.tolerance = 3e-3, .seed = 2}).up[9].value, parts.up[9].value);
  const EnvironmentParts both = measureEnvironment(scene, {.two_sided = true, .tolerance = 3e-3});
  EXPECT_GT(both.rows_with_rays, kPlates / 2);
  for (uint32_t k = 1; k <= kPlates; ++k) EXPECT_NEAR(both.up[k].value, 0.5, 6 * both.up[k].standard_error) << k;
}

TEST(Environment, FineTolerancesHaveRaysInDoublePrecision) {
  constexpr uint32_t kPlates = 8;
  constexpr double kTolerance = 9e-4;
  const Scene scene = buildScene(smallPlatesOverAFloor(kPlates));
  ASSERT_FALSE(hasQuickRays(scene, kTolerance));
  ASSERT_TRUE(hasQuickRays(scene, 1e-3));
  const EnvironmentParts parts = measureEnvironment(scene, {.tolerance = kTolerance});
  EXPECT_TRUE(parts.is_reached);
  EXPECT_GT(parts.rows_with_rays, kPlates / 2);
  for (uint32_t k = 0; k < kPlates; ++k) {
    const double truth = (1 + std::cos(std::numbers::pi * k / kPlates)) / 2;
    // Student's t of 7 degrees of freedom exceeds 7 in size once in 4,700 cases.
    EXPECT_NEAR(parts.up[k + 1].value, truth, 7 * parts.up[k + 1].standard_error) << k;
  }
}

// By surface the plates are one row, whose polygons have rays in proportion to their areas.
TEST(Environment, RaysOfASurfaceAreSharedByItsPolygons) {
  constexpr uint32_t kPlates = 16;
  InputScene input = smallPlatesOverAFloor(kPlates);
  for (InputFace& face : input.faces) face.surface = std::min(face.surface, 1u);
  input.surface_names.resize(2);
  double sums = 0, weights = 0;
  for (size_t k = 1; k < input.faces.size(); k += 2) {
    // Every second plate is half as long, about its first edge.
    std::vector<glm::dvec3>& c = input.faces[k].corners;
    c[2] = (c[1] + c[2]) / 2.0, c[3] = (c[0] + c[3]) / 2.0;
  }
  for (uint32_t k = 0; k < kPlates; ++k) {
    const double weight = k % 2 ? 1 : 0.5;
    sums += weight * (1 + std::cos(std::numbers::pi * k / kPlates)) / 2, weights += weight;
  }
  const EnvironmentParts parts = measureEnvironment(buildScene(input), {.by = By::surface, .tolerance = 1e-3});
  EXPECT_TRUE(parts.is_reached);
  ASSERT_EQ(parts.up.size(), 2u);
  EXPECT_NEAR(parts.ids.areas[1], weights * 0.01 * 0.01, 1e-12);
  EXPECT_NEAR(parts.up[1].value, sums / weights, 7 * parts.up[1].standard_error);
  EXPECT_GE(parts.rays, 8u * kPlates * RayEngine::kLeastRays);
}

// What is known of the whole environment leaves its division open. Then errors of the division alone count, and a run
// that would need more rays than it may cast ends before it casts any.
TEST(Environment, RaysAreForWhatIsOpen) {
  const Scene scene = buildScene(smallPlatesOverAFloor(8));
  const EnvironmentParts few = measureEnvironment(scene, {.tolerance = 3e-3, .most_rays = 100});
  EXPECT_FALSE(few.is_reached);
  EXPECT_EQ(few.rays, 0u);
  EnvironmentRequest request{.tolerance = 3e-3, .whole_environment = std::vector<double>(9, 0.0)};
  EXPECT_EQ(measureEnvironment(scene, request).rays, 0u);  // nothing is left to divide
  request.whole_environment.assign(9, 0.01);
  const EnvironmentParts divided = measureEnvironment(scene, request);
  EXPECT_TRUE(divided.is_reached);
  for (uint32_t row = 0; row < 9; ++row) EXPECT_LE(0.01 * divided.up_share[row].standard_error, 3e-3) << row;
}

// The number of rays that a run expects decides whether it casts them. It is near to the number then cast: within the
// rounding of the last round, which may have 1.5 times as many rays as it needs (kLeastGrowth), and what rows differ.
TEST(Environment, ExpectsAboutTheRaysThatItCasts) {
  const Scene scene = buildScene(bench::triangulatedCity(1'000).scene);
  for (const double tolerance : {1e-2, 2e-3}) {
    EnvironmentRequest request{.tolerance = tolerance};
    const auto rays = double(measureEnvironment(scene, request).rays);
    ASSERT_GT(rays, 1e5);
    request.most_rays = 2 * rays;
    EXPECT_TRUE(measureEnvironment(scene, request).is_reached) << tolerance;
    request.most_rays = rays / 2;
    EXPECT_EQ(measureEnvironment(scene, request).rays, 0u) << tolerance;
  }
}

// A time limit ends a run within a round. The run does not wait for eight replicates of some 10,000 directions or
// more.
TEST(Environment, TimeLimitEndsARunWithinARound) {
  const Scene scene = buildScene(ts::triangleSoup(300, 0.3, 3));
  const auto start = Clock::now();
  const EnvironmentParts parts = measureEnvironment(scene, {.tolerance = 1e-9, .time_limit_s = 0.3});
  EXPECT_FALSE(parts.is_reached);
  EXPECT_GE(parts.replicates, 4u);
  EXPECT_LE(parts.replicates, 8u);
  EXPECT_GT(parts.largest_standard_error, 1e-9);
  // The run stops after some ten milliseconds, or later on a loaded machine. Without the limit it takes minutes.
  EXPECT_LT(secondsSince(start), 5);
  // However short the time is, there are four replicates of 32 directions at least.
  const EnvironmentParts least = measureEnvironment(scene, {.tolerance = 1e-9, .time_limit_s = 1e-6});
  EXPECT_EQ(least.replicates, 4u);
  EXPECT_EQ(least.directions, 4u * 32);
  EXPECT_EQ(least.up_share_errors.size(), 4u);
}

// The two parts add up to the run's form factors but for one rounding, and have the measured shares.
TEST(Environment, SplitsThatOfFormFactors) {
  const Scene scene = buildScene(boxAndPlate());
  const Result all = computeFormFactors(scene, {.goal = Tolerance{1e-2}});
  const EnvironmentParts measured = measureEnvironment(scene, {.tolerance = 2e-3});
  const EnvironmentParts parts = splitEnvironment(all.form_factors, measured);
  bool has_both = false;
  for (uint32_t i = 0; i < parts.ids.count(); ++i) {
    const Measured whole = all.form_factors.formFactor(i, kEnvironment);
    EXPECT_TRUE(isWithin(parts.up[i].value + parts.down[i].value, whole.value, 1e-15));
    EXPECT_EQ(parts.all[i].value, whole.value);
    EXPECT_EQ(parts.up[i].value, whole.value * measured.up_share[i].value);
    EXPECT_GE(parts.up[i].standard_error, whole.standard_error * measured.up_share[i].value);
    EXPECT_LE(parts.up[i].standard_error, parts.largest_standard_error);
    has_both |= parts.up[i].value > 0.1 && parts.down[i].value > 0.1;
  }
  EXPECT_TRUE(has_both);
  const Scene other = buildScene(ts::parallelSquares());
  EXPECT_THROW(splitEnvironment(all.form_factors, measureEnvironment(other, {.tolerance = 0.1})), Error);
  // Without form factors between rows the sum of a row is its environment.
  const FormFactors alone = environmentAlone(measured);
  EXPECT_FALSE(alone.ids().rows_sum_to_one);
  for (uint32_t i = 0; i < parts.ids.count(); ++i) {
    EXPECT_TRUE(isWithin(alone.formFactor(i, kEnvironment).value, measured.all[i].value, 1e-15));
    EXPECT_EQ(alone.formFactor(i, kLeak).value, 0);
    EXPECT_EQ(alone.rowSums()[i].value, measured.all[i].value);
  }
}

MaterialTable apart(Material material, double up, double down) {
  MaterialTable table{"sky", {{"default", std::move(material), 0}}, {}};
  table.sky_and_ground = {up, down};
  return table;
}

// An adiabatic plate has the mean fourth power of the temperatures it sees, whatever its emissivity.
TEST(Environment, AnAdiabaticPlateHasTheMeanOfSkyAndGround) {
  const double tilt = 1.2, share = (1 + std::cos(tilt)) / 2;
  const Scene scene = buildScene(tiltedSquare(tilt));
  const double truth = share * te::power(250) + (1 - share) * te::power(300);
  const Request request{.by = By::surface, .engine = EngineKind::host};
  const SceneHeat found = solveScene(scene, apart(te::flux(0.4, 0), 250, 300), request);
  const HeatRow& plate = found.heat.rows[0];
  EXPECT_TRUE(isEstimateOf(plate.irradiation.value, plate.irradiation.standard_error, truth));
  EXPECT_GT(plate.irradiation.standard_error, 0);
  ASSERT_TRUE(found.heat.to_up && found.heat.to_down);
  EXPECT_TRUE(
      isEstimateOf(found.heat.to_up->value, found.heat.to_up->standard_error, share * (truth - te::power(250))));
  EXPECT_TRUE(isEstimateOf(found.heat.to_down->value, found.heat.to_down->standard_error,
                           (1 - share) * (truth - te::power(300))));
  EXPECT_LE(std::abs(found.heat.balance_residual), 1e-9);
  // If sky and ground are equally warm, they are as one environment.
  MaterialTable whole = apart(te::flux(0.4, 30), 280, 280), one = whole;
  one.sky_and_ground.reset(), one.environment_temperature = 280;
  const HeatRow both = solveScene(scene, whole, request).heat.rows[0],
                single = solveScene(scene, one, request).heat.rows[0];
  EXPECT_TRUE(isWithin(both.temperature.value, single.temperature.value, 1e-11 * 280));
  EXPECT_TRUE(isWithin(both.irradiation.standard_error, single.irradiation.standard_error, 1e-9));
}

}  // namespace
}  // namespace viewpeel
