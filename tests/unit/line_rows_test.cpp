// These tests judge the environment of rows in runs by pair lines. It is 1 less a sum over hundreds of pairs, most of
// which are hidden but for a little. Lines that end on blockers or on backs are in this sum, too.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>

#include "estimator/plan_lines.h"
#include "reference/closed_forms/past_blocker.h"
#include "reference/closed_forms/rectangles.h"
#include "sums/run_sums.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace rt = reference::test;

constexpr double kTolerance = 2e-2;
constexpr uint32_t kTriangles = 100;
constexpr uint64_t kSeeds = 12;

FormFactors compute(const Scene& scene, double tolerance, uint64_t seed) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.two_sided = true;
  request.seed = seed;
  return computeFormFactors(scene, request).form_factors;
}

// RowErrors describes how far the environments of a run's rows are off.
struct RowErrors {
  double mean = 0;            // error, averaged over rows
  double squares = 0;         // sum over rows of the squared error over its standard error
  double largest = 0;         // error
  double largest_stated = 0;  // standard error
};

RowErrors compare(const FormFactors& found, const FormFactors& truth) {
  RowErrors errors;
  for (uint32_t i = 0; i < kTriangles; ++i) {
    const Measured here = found.formFactor(i, kEnvironment), there = truth.formFactor(i, kEnvironment);
    const double error = here.value - there.value;
    errors.mean += error / kTriangles;
    errors.squares += std::pow(error / std::hypot(here.standard_error, there.standard_error), 2);
    errors.largest = std::max(errors.largest, std::abs(error));
    errors.largest_stated = std::max(errors.largest_stated, here.standard_error);
  }
  return errors;
}

// Random triangles, two-sided, hide each other nearly everywhere. Where further lines went to the pairs with the
// largest errors, rows saw 1.1e-3 too much of the environment on average at a tolerance of 1e-2: pairs kept the 0 of
// lines that were all blocked by chance.
TEST(LineRows, EnvironmentHasNoBiasAndItsStandardError) {
  const Scene scene = buildScene(bench::randomTriangles(kTriangles));
  const FormFactors truth = compute(scene, kTolerance / 10, 1000);
  double mean = 0, squares_of_means = 0, squares = 0, largest = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const RowErrors errors = compare(compute(scene, kTolerance, seed), truth);
    mean += errors.mean / kSeeds, squares_of_means += errors.mean * errors.mean / kSeeds;
    squares += errors.squares / (kSeeds * kTriangles);
    largest = std::max(largest, errors.largest);
    EXPECT_LE(errorsInRowGoal(kTriangles) * errors.largest_stated, kTolerance) << seed;
  }
  // The means of 12 seeds are independent, and Student's t with 11 degrees of freedom is beyond 4.44 once in 1,000. The
  // truth has the same error in all seeds: a tenth of a row's, and a hundred rows are averaged, so that it is a
  // hundredth of a row's error of 5e-3.
  EXPECT_LE(std::abs(mean), 4.44 * std::sqrt((squares_of_means - mean * mean) / (kSeeds - 1)) + 5e-5);
  // 1,200 errors of rows with standard errors that are right have a mean square of 1 +- 0.04. A fifth of the standard
  // error, either way, is allowed to the model of eq. (61).
  EXPECT_GE(squares, std::pow(1 / 1.2, 2) - 4 * 0.04);
  EXPECT_LE(squares, std::pow(1.2, 2) + 4 * 0.04);
  // A standard error is at most the tolerance over 3.48, so twice the tolerance is 7 standard errors.
  EXPECT_LE(largest, 2 * kTolerance);
}

// In each of 100 cells two squares face each other past a small blocker, and other cells are far away. So what leaves
// the scene is 1 less a single pair. In many cells nothing blocks any line of this pair, by chance. Without the margin
// of that pair 12 of 2,400 errors were beyond 5 standard errors, the worst by 10.9. Normal errors are once in 1.7
// million.
TEST(LineRows, EnvironmentHoldsWhatASinglePairMayHaveMissed) {
  constexpr int kCells = 100;
  constexpr double kApart = 30;
  rt::Random random(5);
  InputScene input;
  std::vector<double> truths;
  std::vector<rt::Corners> blockers;
  for (int k = 0; k < kCells; ++k) {
    const double side = random.uniform(0.05, 0.3), x = random.uniform(0, 1 - side), y = random.uniform(0, 1 - side);
    const glm::dvec3 at(kApart * k, 0, 0);
    const rt::Corners blocker = rt::rectangle({x, y, 0.5}, {side, 0, 0}, {0, side, 0});
    truths.push_back(1 - reference::formFactorPastBlocker(rt::kFloor, rt::kCeiling, blocker).value -
                     reference::parallelRectangles({0, 1}, {0, 1}, {x, x + side}, {y, y + side}, 0.5));
    blockers.push_back(rt::moved(blocker, 1, at));
    test_scenes::addFace(input, "floor", rt::moved(rt::kFloor, 1, at));
    test_scenes::addFace(input, "ceiling", rt::moved(rt::kCeiling, 1, at));
  }
  for (const rt::Corners& blocker : blockers) test_scenes::addFace(input, "blockers", blocker);
  const Scene scene = buildScene(input);
  int beyond = 0;
  double worst = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Request request;
    request.goal = Tolerance{5e-2};
    request.promise = false;
    request.seed = seed;
    request.question.blockers = {"blockers"};
    const FormFactors found = computeFormFactors(scene, request).form_factors;
    for (int k = 0; k < kCells; ++k)
      for (const uint32_t row : {2 * k, 2 * k + 1}) {
        const Measured environment = found.formFactor(row, kEnvironment);
        const double off = std::abs(environment.value - truths[size_t(k)]) / environment.standard_error;
        worst = std::max(worst, off);
        beyond += off > 5;
      }
  }
  EXPECT_LE(beyond, 2) << worst;
}

// A normal error is beyond 1.96 standard errors with probability 1/20. With 50 rows each one may be so with probability
// 1/1,000, which is 3.29 standard errors.
TEST(LineRows, GoalIsOfAllRowsTogether) {
  EXPECT_NEAR(errorsInRowGoal(1), 1.959964, 1e-6);
  EXPECT_NEAR(errorsInRowGoal(50), 3.290527, 1e-6);
  EXPECT_EQ(errorsInRowGoal(0), errorsInRowGoal(1));
}

// Where a pilot sees a row lose more than its tolerance, lines of pairs measure the leak. So a leak that one line of
// one replicate found is small. By eq. (12) its error is sqrt(2) times its value, without the part for what no
// direction saw. With this part it would be 11 times as large here, and be most of the error of the row's environment.
TEST(LineRows, ALeakOfOneLineErrsByItsSpread) {
  constexpr uint64_t kReplicates = 11;
  const Scene scene = buildScene(bench::randomTriangles(3));
  const Ids ids = makeIds(scene, By::polygon, true);
  RunSums sums = makeRunSums(scene, ids);
  const double exchange = 0.3 * ids.smallerArea(0, 1), error = 1e-4 * exchange;
  sums.lines.emplace(ids, By::polygon, std::vector<LinePair>{{0, 1, exchange, exchange, error}});
  sums.measure_area = 1e-3 * ids.areas[0];
  for (uint64_t k = 0; k < kReplicates; ++k) {
    PairCounts counts{{0, kEnvironment, 300, 0}};
    if (k == 4) counts.push_back({0, kLeak, 1, 0});
    sums.addLines(k, counts, 10, {});
  }
  const FormFactors found = sums.formFactors();
  const Measured leak = found.exchangeArea(0, kLeak), environment = found.exchangeArea(0, kEnvironment);
  EXPECT_NEAR(leak.value, 2 * sums.measure_area / kReplicates, 1e-12 * ids.areas[0]);
  EXPECT_NEAR(leak.standard_error, std::sqrt(2) * leak.value, 1e-12 * ids.areas[0]);
  EXPECT_NEAR(environment.value, ids.areas[0] - exchange - leak.value, 1e-12 * ids.areas[0]);
  EXPECT_NEAR(environment.standard_error, std::hypot(error, leak.standard_error), 1e-12 * ids.areas[0]);
}

// Rays of which none ended on a back say that a row leaks 0 +- one ray's share. If common directions say more, the
// mean of least variance is taken, with the error of the rays. Pairs with backs say all of what other rows leak.
TEST(LineRows, RaysLimitWhatOneLineSaysOfALeak) {
  constexpr uint32_t kRays = 500;
  const Scene scene = buildScene(bench::randomTriangles(3));
  const Ids ids = makeIds(scene, By::polygon, true);
  const auto findWith = [&](LeakingFaces leaking) {
    RunSums sums = makeRunSums(scene, ids);
    sums.lines.emplace(ids, By::polygon, std::vector<LinePair>{}, 0, std::move(leaking));
    sums.measure_area = 1e-3 * ids.areas[0];
    for (uint64_t k = 0; k < 11; ++k) {
      PairCounts counts;
      for (uint32_t i = 0; i < 3; ++i) counts.push_back({i, kEnvironment, 300, 0});
      if (k == 4) counts.insert(counts.begin() + 1, {0, kLeak, 9, 0});
      sums.addLines(k, counts, 10, {});
    }
    return sums.formFactors();
  };
  const FormFactors without = findWith({}), with = findWith({{false, false, true}, kRays});
  const Measured by_directions = without.formFactor(0, kLeak), leak = with.formFactor(0, kLeak);
  constexpr double kShare = 1.0 / kRays;
  const double weight =
      kShare * kShare / (kShare * kShare + by_directions.standard_error * by_directions.standard_error);
  EXPECT_GT(by_directions.standard_error, 0.5 * kShare);
  EXPECT_NEAR(leak.value, weight * by_directions.value, 1e-12);
  EXPECT_NEAR(leak.standard_error, kShare, 1e-12);
  EXPECT_NEAR(with.formFactor(1, kEnvironment).standard_error, kShare, 1e-12);
  EXPECT_EQ(with.formFactor(2, kEnvironment).standard_error, 0);
}

// In a box without a lid hangs a sheet of two faces. Without rows for the sheet, the other form factors stay as they
// are: what ends on the sheet does not reach the sky. A row's sum lacks it.
TEST(LineRows, BlockersLeaveTheEnvironmentAsItIs) {
  constexpr double kCoarse = 1e-2;
  InputScene input = test_scenes::insideOfCube();
  std::erase_if(input.faces, [](const InputFace& face) {
    return std::ranges::all_of(face.corners, [](const glm::dvec3& corner) { return corner.z == 1; });
  });
  ASSERT_EQ(input.faces.size(), 5u);
  const test_scenes::Corners sheet = test_scenes::parallelogram({0.3, 0.3, 0.5}, {0.4, 0, 0}, {0, 0.4, 0});
  test_scenes::addFace(input, "upper", sheet);
  test_scenes::addFace(input, "lower", {sheet.rbegin(), sheet.rend()});
  const Scene scene = buildScene(input);
  const auto resultOf = [&](const Goal& goal, By by, std::optional<bool> promise, std::vector<std::string> blockers) {
    Request request;
    request.by = by, request.goal = goal, request.promise = promise;
    request.question.blockers = std::move(blockers);
    return computeFormFactors(scene, request);
  };
  const EpsilonDelta of_pairs{.epsilon = kCoarse, .delta = 1e-6},
      of_rows{.epsilon = kCoarse, .delta = 1e-6, .rows = true};
  const std::pair<Goal, std::optional<bool>> goals[] = {
      {Tolerance{kCoarse}, true}, {Tolerance{kCoarse}, false}, {of_pairs, std::nullopt}, {of_rows, std::nullopt}};
  for (const auto& [goal, promise] : goals)
    for (const By by : {By::polygon, By::surface}) {
      const FormFactors all = resultOf(goal, by, promise, {}).form_factors;
      const Result found = resultOf(goal, by, promise, {"upper", "lower"});
      const FormFactors& rest = found.form_factors;
      const uint32_t upper = 5, lower = 6;  // each side of the cube is a surface
      ASSERT_EQ(all.ids().names[upper].substr(0, 5), "upper");
      EXPECT_EQ(rest.hasIntervals(), promise != std::optional(false));
      for (uint32_t i = 0; i < upper; ++i) {
        const double left = all.formFactor(i, kEnvironment).value,
                     on_sheet = all.formFactor(i, upper).value + all.formFactor(i, lower).value;
        EXPECT_GT(left, 0.1);
        // All form factors of both runs are within the tolerance.
        EXPECT_NEAR(rest.formFactor(i, kEnvironment).value, left, 2 * kCoarse) << rest.ids().names[i];
        EXPECT_NEAR(rest.rowSums()[i].value, 1 - on_sheet, 4 * kCoarse) << rest.ids().names[i];
        for (uint32_t j = 0; j < upper; ++j)
          EXPECT_NEAR(rest.formFactor(i, j).value, all.formFactor(i, j).value, 2 * kCoarse);
      }
      for (const FormFactors* of : {&rest, &found.between_surfaces})
        for (const FormFactors::Entry& entry : of->entries())
          EXPECT_TRUE(entry.i < upper && (entry.j < upper || entry.j >= kEnvironment));
      if (rest.hasIntervals()) {
        ASSERT_EQ(rest.intervals().size(), rest.entries().size());
        for (size_t k = 0; k < rest.entries().size(); ++k) {
          const double value = rest.entries()[k].exchange_area.value;
          EXPECT_TRUE(rest.intervals()[k].lower <= value && value <= rest.intervals()[k].upper);
        }
      }
    }
}

// A ground leaks to the back of a small plate, which no ray of the survey meets. The plate is exposed, and has lines.
// So the environment is exact, for nothing is in between.
TEST(LineRows, FewExposedBacksHaveLinesWhateverRaysMeet) {
  InputScene input;
  test_scenes::addFace(input, "ground", test_scenes::parallelogram({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}));
  test_scenes::addFace(input, "plate", test_scenes::parallelogram({0.3, 0.3, 0.05}, {0.2, 0, 0}, {0, 0.2, 0}));
  const Scene scene = buildScene(input);
  const double leak = reference::parallelRectangles({-5, 5}, {-5, 5}, {0.3, 0.5}, {0.3, 0.5}, 0.05);
  EXPECT_LT(leak, 1.0 / 1024);  // at 1e-2 there are 64 rays
  const EpsilonDelta guarantee{.epsilon = 1e-2, .delta = 1e-2};
  for (const Goal& goal : {Goal(Tolerance{1e-2}), Goal(guarantee), Goal(RootMeanSquare{1e-2}), Goal(Seconds{0.1})})
    for (const uint64_t seed : {1, 2, 3}) {
      Request request;
      request.by = By::polygon, request.seed = seed, request.goal = goal, request.pair_lines = true;
      const FormFactors found = computeFormFactors(scene, request).form_factors;
      EXPECT_NEAR(found.formFactor(0, kLeak).value, leak, 1e-8);
      EXPECT_NEAR(found.formFactor(0, kEnvironment).value, 1 - leak, 1e-8);
    }
}

}  // namespace
}  // namespace viewpeel
