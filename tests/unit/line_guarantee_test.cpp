// These tests check guarantees by pair lines. Intervals hold integrals past blockers, over many seeds and in scenes
// that are hard to sample. Geometry alone proves some bounds. The environment and sums over surfaces have intervals,
// too.
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>

#include "reference/closed_forms/past_blocker.h"
#include "scenes/named_scenes.h"
#include "tests/support/face_pairs.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
namespace rt = reference::test;
using rt::kCeiling, rt::kFloor;
using test::sceneOf;

Request guaranteeOf(double epsilon, double delta, uint64_t seed = 1) {
  Request request;
  request.goal = EpsilonDelta{.epsilon = epsilon, .delta = delta};
  request.engine = EngineKind::host;
  request.seed = seed;
  return request;
}

// Returns F from a to b past slats in one plane. Each slat takes its share away, for their shadows do not overlap.
double pastSlats(const rt::Corners& a, const rt::Corners& b, const std::vector<rt::Corners>& slats) {
  const double clear = reference::formFactorPastBlocker(a, b, rt::moved(slats[0], 1, {90, 0, 0})).value;
  double past = clear;
  for (const rt::Corners& slat : slats) past -= clear - reference::formFactorPastBlocker(a, b, slat).value;
  return past;
}

Result guarantee(const std::vector<rt::Corners>& faces, double epsilon, double delta, uint64_t seed = 1) {
  return computeFormFactors(sceneOf(faces), guaranteeOf(epsilon, delta, seed));
}

// Of 1,000 runs with different seeds a share of at most delta may fail. A binomial count exceeds its mean by 3.9
// standard deviations once in 20,000 tests. Negative control: intervals a fifth as wide about the same values fail far
// more often.
TEST(LineGuarantee, FailsNoMoreOftenThanItMay) {
  constexpr double kDelta = 0.2, kEpsilon = 0.05;
  constexpr int kSeeds = 1000;
  const rt::Corners near = rt::rectangle({-0.1, -2, 0.4}, {0.5, 0, 0}, {0, 5, 0}),
                    wall = rt::rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const Scene scene = sceneOf({kFloor, kCeiling, wall, near});
  const double truths[3] = {reference::formFactorPastBlocker(kFloor, kCeiling, near).value,
                            reference::formFactorPastBlocker(kFloor, wall, near).value,
                            reference::formFactorPastBlocker(kCeiling, wall, near).value};
  const std::pair<uint32_t, uint32_t> pairs[3] = {{0, 1}, {0, 2}, {1, 2}};
  int failures = 0, narrow_failures = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Result result = computeFormFactors(scene, guaranteeOf(kEpsilon, kDelta, seed));
    ASSERT_TRUE(result.guarantee);
    EXPECT_LE(result.guarantee->bound, kEpsilon);
    bool fails = false, narrow_fails = false;
    for (int k = 0; k < 3; ++k) {
      const auto [i, j] = pairs[k];
      const Interval interval = result.form_factors.interval(i, j);
      const double value = result.form_factors.formFactor(i, j).value, truth = truths[k];
      fails |= truth < interval.lower || truth > interval.upper || std::abs(value - truth) > kEpsilon;
      narrow_fails |= std::abs(value - truth) > 0.2 * (interval.upper - interval.lower) / 2;
    }
    failures += fails, narrow_failures += narrow_fails;
  }
  const double most = kSeeds * kDelta + 3.9 * std::sqrt(kSeeds * kDelta * (1 - kDelta));
  EXPECT_LE(failures, most);
  EXPECT_GT(narrow_failures, most);
}

// In these scenes evenly spread points all err together (comb, slit), or a rule that stops early misses the blocker
// (thin blocker, fin).
TEST(LineGuarantee, HoldsWhereScenesDeceive) {
  std::vector<rt::Corners> comb, grid;
  constexpr int kSlats = 128;
  for (int k = 0; k < kSlats; ++k)
    comb.push_back(rt::rectangle({(k + 0.25) / kSlats, -3, 0.5}, {0.5 / kSlats, 0, 0}, {0, 7, 0}));
  const rt::Corners thin = rt::rectangle({0.4999, -3, 0.5}, {2e-4, 0, 0}, {0, 7, 0}),
                    left = rt::rectangle({-3, -3, 0.5}, {3.4999, 0, 0}, {0, 7, 0}),
                    right = rt::rectangle({0.5001, -3, 0.5}, {3.4999, 0, 0}, {0, 7, 0}),
                    wall = rt::rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                    fin = rt::rectangle({0.01, -1, 0.01}, {0.05, 0, 0.05}, {0, 3, 0});
  const struct {
    const char* name;
    rt::Corners second;
    std::vector<rt::Corners> blockers;
  } scenes[] = {{"comb", kCeiling, comb},
                {"thin blocker", kCeiling, {thin}},
                {"slit", kCeiling, {left, right}},
                {"fin in a corner", wall, {fin}}};
  for (const auto& [name, second, blockers] : scenes) {
    const double truth = pastSlats(kFloor, second, blockers);
    std::vector<rt::Corners> faces{kFloor, second};
    faces.insert(faces.end(), blockers.begin(), blockers.end());
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      // Of 20 runs with delta = 1e-4 one fails by chance in one of 500 tests.
      const Result result = guarantee(faces, 5e-3, 1e-4, seed);
      const Interval interval = result.form_factors.interval(0, 1);
      EXPECT_LE(interval.lower, truth + 1e-6) << name;
      EXPECT_GE(interval.upper, truth - 1e-6) << name;
      EXPECT_LE(interval.upper - interval.lower, 2 * 5e-3 + 1e-9) << name;
      EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, truth, 5e-3) << name;
    }
  }
}

// A surface has two squares. A thin blocker hides little of what the first one sees, and a large plate leaves little to
// the second. Lines in strata of each agree in many runs, and the standard error allows for the others: it was below
// 1e-12 then. Of 20 normal errors one is beyond five once in 80,000 tests.
TEST(LineGuarantee, StandardErrorsAllowForLinesThatWereNotDrawn) {
  constexpr double kSize = 2.7, kEpsilon = 2e-3;  // size of the second square
  const glm::dvec3 apart(30, 0, 0);
  const rt::Corners thin = rt::rectangle({0.4999, -3, 0.5}, {5e-4, 0, 0}, {0, 7, 0}),
                    plate = rt::rectangle({-3, -3, 0.5}, {3.998, 0, 0}, {0, 7, 0});
  const double of_second = kSize * kSize,
               truth = (reference::formFactorPastBlocker(kFloor, kCeiling, thin).value +
                        of_second * reference::formFactorPastBlocker(kFloor, kCeiling, plate).value) /
                       (1 + of_second);
  InputScene input{"two squares", {}, {}};
  ts::addFace(input, "lower", kFloor), ts::addFace(input, "lower", rt::moved(kFloor, kSize, apart));
  ts::addFace(input, "upper", kCeiling), ts::addFace(input, "upper", rt::moved(kCeiling, kSize, apart));
  ts::addFace(input, "blockers", thin), ts::addFace(input, "blockers", rt::moved(plate, kSize, apart));
  const Scene scene = buildScene(input);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Request request = guaranteeOf(kEpsilon, 1e-2, seed);
    request.by = By::surface;
    const Measured found = computeFormFactors(scene, request).form_factors.formFactor(0, 1);
    EXPECT_NEAR(found.value, truth, 5 * found.standard_error) << seed;
  }
}

TEST(LineGuarantee, HoldsForRandomPairsPastABlocker) {
  rt::Random random(19);
  int tried = 0;
  for (int trial = 0; trial < 200 && tried < 40; ++trial) {
    const auto [a, b] = rt::randomPair(random);
    const rt::Corners blocker = random.convexPolygon(0.5 * (a[0] + b[0]), random.direction(), 4);
    const double truth = reference::formFactorPastBlocker(a, b, blocker).value;
    if (!(truth > 1e-3)) continue;
    ++tried;
    const Result result = guarantee({a, b, blocker}, 2e-3, 1e-4, uint64_t(trial));
    const Interval interval = result.form_factors.interval(0, 1);
    EXPECT_LE(interval.lower, truth + 1e-6) << trial;
    EXPECT_GE(interval.upper, truth - 1e-6) << trial;
    ASSERT_TRUE(result.guarantee);
    EXPECT_LE(result.guarantee->bound, 2e-3) << trial;
  }
  EXPECT_EQ(tried, 40);
}

TEST(LineGuarantee, GeometryAloneProvesWhatNothingBlocks) {
  const Result cube = computeFormFactors(buildScene(ts::insideOfCube()), guaranteeOf(1e-3, 0.01));
  ASSERT_TRUE(cube.guarantee);
  EXPECT_EQ(cube.guarantee->delta, 0);
  EXPECT_EQ(cube.lines, 0u);
  EXPECT_LT(cube.guarantee->bound, 1e-5);
  EXPECT_NEAR(cube.form_factors.formFactor(0, 1).value, 0.2, 1e-3);
  // With delta = 0 the intervals follow from geometry alone, however wide they are.
  const rt::Corners half = rt::rectangle({0.5, -1, 0.5}, {3, 0, 0}, {0, 3, 0});
  const Result certain = guarantee({kFloor, kCeiling, half}, 1e-3, 0);
  const double clear = reference::formFactorPastBlocker(kFloor, kCeiling, rt::moved(half, 1, {90, 0, 0})).value;
  EXPECT_EQ(certain.form_factors.interval(0, 1).lower, 0);
  EXPECT_NEAR(certain.form_factors.interval(0, 1).upper, clear, 1e-5);
  EXPECT_GT(certain.guarantee->bound, 1e-3);
  EXPECT_EQ(certain.guarantee->delta, 0);
  Request rows = guaranteeOf(1e-3, 0);
  std::get<EpsilonDelta>(rows.goal).rows = true;
  EXPECT_EQ(computeFormFactors(sceneOf({kFloor, kCeiling, half}), rows).guarantee->delta, 0);
  // With epsilon = 0.5 geometry bounds all pairs, but the interval of the environment follows from lines.
  EXPECT_EQ(guarantee({kFloor, kCeiling, half}, 0.5, 0.01).guarantee->delta, 0.01);
}

// One wall of a room with boxes is missing. The interval of the environment follows from all lines of its row. It holds
// the truth, and is no wider than the intervals of the row's entries together, from which it would follow as well. In
// some rows it is narrower. Where the request has `rows` it is at most 2 epsilon wide.
TEST(LineGuarantee, TheEnvironmentHasASeparateBound) {
  InputScene input = ts::roomWithTouchingBoxes();
  std::erase_if(input.faces, [&](const auto& face) { return &face == &input.faces.front(); });
  const Scene scene = buildScene(input);
  Request fine;
  fine.goal = Tolerance{2e-4};
  fine.engine = EngineKind::host;
  const Result truth = computeFormFactors(scene, fine);
  for (const bool rows : {false, true}) {
    Request request = guaranteeOf(0.02, 1e-4);
    std::get<EpsilonDelta>(request.goal).rows = rows;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.guarantee);
    const FormFactors& found = result.form_factors;
    std::vector<double> sum_of_widths(found.ids().count(), 0);
    const auto addWidth = [&](uint32_t i, uint32_t j) {
      const Interval interval = found.interval(i, j);
      sum_of_widths[i] += interval.upper - interval.lower;
    };
    for (const FormFactors::Entry& entry : found.entries()) {
      if (entry.j == kEnvironment) continue;
      addWidth(entry.i, entry.j);
      if (entry.j < kEnvironment && entry.j != entry.i) addWidth(entry.j, entry.i);
    }
    bool sees_environment = false, is_narrower = false;
    for (uint32_t i = 0; i < found.ids().count(); ++i) {
      const Measured expected = truth.form_factors.formFactor(i, kEnvironment);
      if (!(expected.value > 0)) continue;
      sees_environment = true;
      const Interval interval = found.interval(i, kEnvironment);
      // The largest error of the reference is about its goal, 2e-4. The slack is five times this goal.
      EXPECT_LE(interval.lower, expected.value + 1e-3) << found.ids().names[i];
      EXPECT_GE(interval.upper, expected.value - 1e-3) << found.ids().names[i];
      const double width = interval.upper - interval.lower;
      EXPECT_LE(width, sum_of_widths[i] + 1e-9) << found.ids().names[i];
      is_narrower = is_narrower || width < 0.9 * sum_of_widths[i];
      EXPECT_LE(width, rows ? 2 * 0.02 + 1e-9 : INFINITY) << found.ids().names[i];
    }
    EXPECT_TRUE(sees_environment);
    EXPECT_TRUE(is_narrower);
    EXPECT_GT(result.guarantee->row_bound, 0);
    EXPECT_LE(result.guarantee->row_bound, rows ? 2 * 0.02 : 1);
  }
}

TEST(LineGuarantee, SumsOverSurfacesHaveFewerLines) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  Request by_surface = guaranteeOf(5e-3, 1e-3), fine = by_surface;
  by_surface.by = fine.by = By::surface;
  fine.goal = Tolerance{2e-4};
  const Result result = computeFormFactors(scene, by_surface), truth = computeFormFactors(scene, fine);
  ASSERT_TRUE(result.guarantee);
  for (const FormFactors::Entry& entry : truth.form_factors.entries()) {
    if (entry.j >= kEnvironment) continue;
    const Interval interval = result.form_factors.interval(entry.i, entry.j);
    const double expected = truth.form_factors.formFactor(entry.i, entry.j).value;
    EXPECT_LE(interval.lower, expected + 1e-3);
    EXPECT_GE(interval.upper, expected - 1e-3);
  }
  EXPECT_LT(result.lines, computeFormFactors(scene, guaranteeOf(5e-3, 1e-3)).lines);  // by polygon
}

// A Corner is a strip on the ground, an upright strip that touches one of its ends, and what lies between them. Density
// f has no useful bound where the two touch, and their form factor is tiny, so that nearly all candidates are rejected.
struct Corner {
  rt::Corners ground, upright, blocker;
};

// Returns a corner whose ground strip is 1 long, `width` wide, and points away from the origin, `distance` from it.
Corner cornerOfStrips(double width, double distance, double angle_rad) {
  const glm::dvec3 away(std::cos(angle_rad), std::sin(angle_rad), 0), up(0, 0, 1);
  const glm::dvec3 side = glm::cross(up, away), corner = distance * away;
  return {rt::rectangle(corner, away, width * side), rt::rectangle(corner, width * side, up),
          rt::rectangle(corner + 0.2 * away + 0.4 * up - side, 0.2 * away, 2.0 * side)};
}

// All lines of two strips are left open, for they cost too many candidates. The run ends, and its intervals hold.
TEST(LineGuarantee, StripsThatTouchAtTheirEndsAreLeftOpen) {
  const auto [ground, upright, blocker] = cornerOfStrips(1e-5, 0, 0);
  const Result result = guarantee({ground, upright, kCeiling, blocker}, 1e-2, 1e-2);
  ASSERT_TRUE(result.guarantee);
  EXPECT_LE(result.guarantee->bound, 1e-2);
  EXPECT_GT(result.form_factors.interval(0, 1).upper, 0);
  EXPECT_EQ(result.form_factors.interval(0, 1).lower, 0);
  const double truth = reference::formFactorPastBlocker(ground, kCeiling, blocker).value;
  EXPECT_LE(result.form_factors.interval(0, 2).lower, truth + 1e-5);
  EXPECT_GE(result.form_factors.interval(0, 2).upper, truth - 1e-5);
  for (uint32_t i = 0; i < result.form_factors.ids().count(); ++i)
    EXPECT_GE(result.form_factors.interval(i, kEnvironment).upper, result.form_factors.interval(i, kEnvironment).lower);
}

// A sum has one part that matters and many that are left open. The bound counts the lines of the first, and not the
// lines that guess the others.
TEST(LineGuarantee, SumsWithOpenPartsFailNoMoreOftenThanTheyMay) {
  constexpr double kDelta = 0.2, kEpsilon = 0.05, kWidth = 1e-6;
  constexpr int kSeeds = 60, kStrips = 24;
  const rt::Corners blocker = rt::rectangle({-0.1, -2, 0.4}, {0.5, 0, 0}, {0, 5, 0});
  InputScene input{"strips", {}, {}};
  ts::addFace(input, "lower", kFloor);
  const auto addStrips = [&](const char* name, rt::Corners Corner::*face) {
    for (int k = 0; k < kStrips; ++k)
      ts::addFace(input, name, cornerOfStrips(kWidth, 100, 2 * std::numbers::pi * k / kStrips).*face);
  };
  addStrips("lower", &Corner::ground);
  ts::addFace(input, "upper", kCeiling);
  addStrips("upper", &Corner::upright);
  ts::addFace(input, "blockers", blocker);
  addStrips("blockers", &Corner::blocker);
  const Scene scene = buildScene(input);
  const double truth = reference::formFactorPastBlocker(kFloor, kCeiling, blocker).value;
  int failures = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Request request = guaranteeOf(kEpsilon, kDelta, seed);
    request.by = By::surface;
    const Result result = computeFormFactors(scene, request);
    const Interval interval = result.form_factors.interval(0, 1);
    failures += truth < interval.lower || truth > interval.upper;
  }
  EXPECT_LE(failures, kSeeds * kDelta + 3.9 * std::sqrt(kSeeds * kDelta * (1 - kDelta)));
}

TEST(LineGuarantee, ThreadsDoNotMatter) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  Request one = guaranteeOf(0.01, 0.01), three = one;
  one.threads = 1, three.threads = 3;
  const Result a = computeFormFactors(scene, one), b = computeFormFactors(scene, three);
  ASSERT_EQ(a.form_factors.entries().size(), b.form_factors.entries().size());
  for (size_t k = 0; k < a.form_factors.entries().size(); ++k) {
    EXPECT_EQ(a.form_factors.entries()[k].exchange_area.value, b.form_factors.entries()[k].exchange_area.value);
    EXPECT_EQ(a.form_factors.intervals()[k].upper, b.form_factors.intervals()[k].upper);
  }
}

TEST(LineGuarantee, WhatCannotBeKeptIsRefused) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  EXPECT_THROW(computeFormFactors(scene, guaranteeOf(1e-6, 0.01)), Error);
  Request short_of_time = guaranteeOf(2e-5, 0.01);
  short_of_time.time_limit_s = 0.1;
  EXPECT_THROW(computeFormFactors(scene, short_of_time), Error);
}

}  // namespace
}  // namespace viewpeel
