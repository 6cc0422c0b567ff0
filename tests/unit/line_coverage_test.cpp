// Intervals of guarantees by pair lines fail as rarely as stated, by the binomial law. In the worst case intervals a
// tenth too small fail too often. One pair among 100,000 hides behind a grid.
#include <cmath>

#include <boost/math/distributions/binomial.hpp>
#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>

#include "reference/closed_forms/past_blocker.h"
#include "scenes/named_scenes.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
namespace rt = reference::test;
using rt::kCeiling, rt::kFloor;

constexpr double kFalseAlarm = 1e-4;

// Returns a number of failures that runs which fail with probability p or less exceed with probability kFalseAlarm.
double mostFailures(int runs, double p) {
  return boost::math::quantile(boost::math::complement(boost::math::binomial(runs, p), kFalseAlarm));
}

rt::Corners strip(double width) { return rt::rectangle({0.4, -3, 0.5}, {width, 0, 0}, {0, 7, 0}); }

double pastStrip(double width) { return reference::formFactorPastBlocker(kFloor, kCeiling, strip(width)).value; }

// Returns the width of a strip that leaves this share of the lines between floor and ceiling.
double widthOf(double visibility, double clear) {
  double narrow = 0, wide = 0.5;
  while (wide - narrow > 1e-9) {
    const double middle = (narrow + wide) / 2;
    (pastStrip(middle) > visibility * clear ? narrow : wide) = middle;
  }
  return narrow;
}

struct Failures {
  int intervals = 0, smaller = 0;  // counts of lower ends above the truth; `smaller`: of intervals a tenth smaller
};

// A pair has 16 lines in one look. If all of them are facing, the visibility is at least e^(-l / 16), with l = ln(2 /
// delta). This bound is exact: a visibility just below it fails with probability delta / 2, the most that is allowed.
// A visibility just above it never fails, unless the interval is a tenth smaller: then it fails more often than
// allowed.
TEST(LineCoverage, IntervalsATenthTooSmallAreCaught) {
  constexpr double kDelta = 0.18, kLines = 16;
  const double clear = reference::formFactorPastBlocker(kFloor, kCeiling, rt::moved(strip(0.1), 1, {90, 0, 0})).value;
  const double l = std::log(2 / kDelta), bound = std::exp(-l / kLines), smaller_bound = 1 - 0.9 * (1 - bound);
  const auto countFailures = [&](double visibility, int runs) {
    const double width = widthOf(visibility, clear), truth = pastStrip(width);
    InputScene input{"strip", {}, {}};
    ts::addFace(input, "floor", kFloor);
    ts::addFace(input, "ceiling", kCeiling);
    ts::addFace(input, "strip", strip(width));
    const Scene scene = buildScene(input);
    Request request;
    request.goal = EpsilonDelta{.epsilon = 0.1, .delta = kDelta};
    request.question.pair = {"floor", "ceiling"};
    request.engine = EngineKind::host;
    request.threads = 1;
    Failures failures;
    for (int run = 1; run <= runs; ++run) {
      request.seed = static_cast<uint64_t>(run);
      const Result result = computeFormFactors(scene, request);
      EXPECT_EQ(double(result.lines), kLines);
      if (double(result.lines) != kLines) break;
      const double value = result.form_factors.formFactor(0, 1).value, lower = result.form_factors.interval(0, 1).lower;
      failures.intervals += lower > truth;
      failures.smaller += value - 0.9 * (value - lower) > truth;
    }
    return failures;
  };
  constexpr int kBelow = 1500, kAbove = 5000;
  const Failures below = countFailures(bound - 1e-3, kBelow);
  EXPECT_LE(below.intervals, mostFailures(kBelow, kDelta / 2));
  EXPECT_GE(below.intervals, 0.75 * kBelow * kDelta / 2);  // nearly all that is allowed: the test is not an idle one
  const Failures above = countFailures(smaller_bound - 5e-4, kAbove);
  EXPECT_LE(above.intervals, mostFailures(kAbove, kDelta / 2));
  EXPECT_GT(above.smaller, mostFailures(kAbove, kDelta / 2));
}

// Of 324 parts of a floor and 324 parts of a ceiling, one pair has a grid of 64 slats between, finer than any lattice
// of common directions. Its form factor is an integral past each slat, for the slats' shadows do not overlap. Every
// interval holds with probability 0.9999, so the three seeds fail once in 3,000.
TEST(LineCoverage, OnePairOf100000HidesBehindAGrid) {
  constexpr uint32_t kCuts = 18, kMiddle = kCuts * kCuts / 2 + kCuts / 2, kSlats = 64;
  constexpr double kHeight = 2, kEpsilon = 5e-3;
  InputScene input = ts::squaresInParts(kCuts, 1, kHeight);
  const auto cornersOf = [&](uint32_t face) { return input.faces[face].corners; };
  const uint32_t low = 2 * kMiddle, high = low + 1;
  const rt::Corners below = cornersOf(low), above = cornersOf(high);
  const double x = below[0].x, y = below[0].y;
  const auto slat = [&](uint32_t k) {
    return rt::rectangle({x + (k + 0.25) / kSlats, y - 0.5, kHeight / 2}, {0.5 / kSlats, 0, 0}, {0, 2, 0});
  };
  const double clear = reference::formFactorPastBlocker(below, above, rt::moved(slat(0), 1, {90, 0, 0})).value;
  double truth = clear;
  for (uint32_t k = 0; k < kSlats; ++k) {
    truth -= clear - reference::formFactorPastBlocker(below, above, slat(k)).value;
    ts::addFace(input, "grid", slat(k));
  }
  ASSERT_GT(clear - truth, 4 * kEpsilon);  // the grid changes the form factor by far more than epsilon
  const Scene scene = buildScene(input);
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    Request request;
    request.goal = EpsilonDelta{.epsilon = kEpsilon, .delta = 1e-4};
    request.engine = EngineKind::host;
    request.seed = seed;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.guarantee);
    EXPECT_GT(
        result.plan.line_guarantee->exact + result.plan.line_guarantee->bounded + result.plan.line_guarantee->drawn,
        100'000u);
    const Interval interval = result.form_factors.interval(low, high);
    EXPECT_LE(interval.lower, truth) << seed;
    EXPECT_GE(interval.upper, truth) << seed;
    EXPECT_NEAR(result.form_factors.formFactor(low, high).value, truth, kEpsilon) << seed;
    // The pair two columns aside has nothing in between.
    EXPECT_NEAR(result.form_factors.formFactor(low - 4, high - 4).value, clear, kEpsilon) << seed;
  }
}

// Above 8,000 polygons pairs with an unoccluded form factor below epsilon get no lines: any value in [0, epsilon] is
// right.
TEST(LineCoverage, LargeScenesHaveLinesWhereEpsilonNeedsThem) {
  constexpr uint32_t kCuts = 64, kMiddle = kCuts * kCuts / 2 + kCuts / 2;
  constexpr double kEpsilon = 0.02;
  InputScene input = ts::squaresInParts(kCuts, 1, 2);
  const uint32_t low = 2 * kMiddle, high = low + 1, beside = high + 2, far = high + 40;
  const auto cornersOf = [&](uint32_t face) { return input.faces[face].corners; };
  const glm::dvec3 corner = cornersOf(low)[0];
  const rt::Corners plate = rt::rectangle({corner.x + 0.2, corner.y - 1, 1}, {0.5, 0, 0}, {0, 3, 0});
  ts::addFace(input, "plate", plate);
  const Scene scene = buildScene(input);
  ASSERT_GT(scene.faces.size(), 8'000u);
  Request request;
  request.goal = EpsilonDelta{.epsilon = kEpsilon, .delta = 1e-4};
  request.engine = EngineKind::host;
  const Result result = computeFormFactors(scene, request);
  ASSERT_TRUE(result.guarantee);
  EXPECT_EQ(result.guarantee->bound, kEpsilon);
  const FormFactors& f = result.form_factors;
  EXPECT_EQ(f.unlistedBound(), kEpsilon);
  EXPECT_LT(result.line_pairs, 100'000u);  // of 16 million
  for (const uint32_t to : {high, beside, far}) {
    const double truth = reference::formFactorPastBlocker(cornersOf(low), cornersOf(to), plate).value;
    const Interval interval = f.interval(low, to);
    EXPECT_LE(interval.lower, truth) << to;
    EXPECT_GE(interval.upper, truth) << to;
    EXPECT_NEAR(f.formFactor(low, to).value, truth, kEpsilon) << to;
  }
  EXPECT_GT(f.interval(low, high).lower, 0);
  // Values of pairs without lines come from common directions, so rows sum to 1 up to the error of these directions.
  int counted = 0;
  for (size_t k = 0; k < f.entries().size(); ++k) {
    const FormFactors::Entry& entry = f.entries()[k];
    const Interval& interval = f.intervals()[k];
    ASSERT_LE(interval.lower, entry.exchange_area.value) << entry.i << ", " << entry.j;
    ASSERT_GE(interval.upper, entry.exchange_area.value) << entry.i << ", " << entry.j;
    if (entry.j >= kEnvironment) continue;
    ASSERT_LE(interval.upper - interval.lower, 2 * kEpsilon * f.ids().smallerArea(entry.i, entry.j) + 1e-12);
    counted += interval.lower == 0;
  }
  EXPECT_GT(counted, 100'000);
  EXPECT_NEAR(f.rowSums()[low].value, 1, 6 * f.rowSums()[low].standard_error + 1e-6);
}

}  // namespace
}  // namespace viewpeel
