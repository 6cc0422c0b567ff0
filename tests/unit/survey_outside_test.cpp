// What leaves a scene or ends on backs is found where common directions hardly meet a polygon.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <viewpeel/compute.h>
#include "estimator/survey_outside.h"
#include "reference/closed_forms/rectangles.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kSize = 0.1, kApart = 0.05;  // of a pair of squares
const double kOfSquares = reference::parallelRectangles({0, kSize}, {0, kSize}, {0, kSize}, {0, kSize}, kApart);

// Returns pairs of squares, "low 0" under "high 0" and so on, all kilometres apart.
//   In: faces: whether they face each other; else both look upwards, and the low one sees the other's back
InputScene farAwayPairs(bool faces) {
  InputScene input;
  for (int k = 0; k < 20; ++k) {
    const double x = 1000.0 * k, y = 1000.0 * (k * k % 7);
    const glm::dvec3 right(kSize, 0, 0), back(0, kSize, 0);
    ts::addFace(input, "low " + std::to_string(k), ts::parallelogram({x, y, 0}, right, back));
    ts::addFace(
        input, "high " + std::to_string(k),
        faces ? ts::parallelogram({x, y, kApart}, back, right) : ts::parallelogram({x, y, kApart}, right, back));
  }
  return input;
}

OutsideShares survey(const InputScene& input) {
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeRayEngine(scene, ids, {.thread_count = 2});
  return surveyOutside(*engine, scene, ids, 64, 1);
}

TEST(SurveyOutside, FindsNothingInClosedScenes) {
  for (const InputScene& input : {ts::insideOfCube(), ts::cubeInCube(0.4), ts::roomWithTouchingBoxes()}) {
    EXPECT_EQ(survey(input).largest_environment, 0) << input.file;
    EXPECT_EQ(survey(input).largest_leak, 0) << input.file;
  }
}

TEST(SurveyOutside, MeasuresTheLargestShares) {
  // Shares of 64 and of 1,024 independent rays have these standard errors; the rows' largest is off by six at most.
  const double error_of_64 = std::sqrt(kOfSquares * (1 - kOfSquares) / 64), error_of_1024 = error_of_64 / 4;
  const OutsideShares open = survey(farAwayPairs(true)), leaking = survey(farAwayPairs(false));
  EXPECT_NEAR(open.largest_environment, 1 - kOfSquares, 6 * error_of_64);
  EXPECT_EQ(open.largest_leak, 0);
  EXPECT_EQ(leaking.largest_environment, 1);  // of the high squares
  EXPECT_NEAR(leaking.largest_leak, kOfSquares, 6 * error_of_1024);
}

// No line of a common direction meets these squares. Rows still add up to 1, by the environment that is left.
TEST(SurveyOutside, RowsOfFarAwayPartsHaveTheirEnvironment) {
  const Scene scene = buildScene(farAwayPairs(true));
  for (const bool promise : {false, true})
    for (const By by : {By::polygon, By::surface}) {
      Request request;
      request.by = by, request.promise = promise;
      request.goal = Tolerance{1e-2};
      const FormFactors found = computeFormFactors(scene, request).form_factors;
      for (uint32_t i = 0; i < found.ids().count(); ++i) {
        EXPECT_NEAR(found.formFactor(i, kEnvironment).value, 1 - kOfSquares, 1e-8);
        EXPECT_NEAR(found.rowSums()[i].value, 1, 1e-12);
      }
      EXPECT_EQ(found.hasIntervals(), promise);
    }
}

// In a box without a lid hangs a sheet of two faces. Rows see as much of the sky where the sheet has no row. By lines
// that would be 1 less the pairs of a row, and so hold what ends on the sheet.
TEST(SurveyOutside, BlockersLeaveTheEnvironmentAsItIs) {
  constexpr double kTolerance = 1e-2;
  InputScene input = ts::insideOfCube();
  std::erase_if(input.faces, [](const InputFace& face) {
    return std::ranges::all_of(face.corners, [](const glm::dvec3& corner) { return corner.z == 1; });
  });
  ASSERT_EQ(input.faces.size(), 5u);
  const ts::Corners sheet = ts::parallelogram({0.3, 0.3, 0.5}, {0.4, 0, 0}, {0, 0.4, 0});
  ts::addFace(input, "upper", sheet);
  ts::addFace(input, "lower", {sheet.rbegin(), sheet.rend()});
  const Scene scene = buildScene(input);
  for (const Goal& goal : {Goal(Tolerance{kTolerance}), Goal(EpsilonDelta{.epsilon = kTolerance, .delta = 1e-6})}) {
    Request request;
    request.by = By::polygon, request.goal = goal;
    const FormFactors all = computeFormFactors(scene, request).form_factors;
    request.question.blockers = {"upper", "lower"};
    const FormFactors found = computeFormFactors(scene, request).form_factors;
    for (uint32_t i = 0; i < 5; ++i) {
      // All form factors are within the tolerance of the true ones. Common directions have it for a standard error.
      const double left = all.formFactor(i, kEnvironment).value;
      const Measured by_directions = found.formFactor(i, kEnvironment);
      EXPECT_GT(left, 0.1);
      EXPECT_NEAR(by_directions.value, left, kTolerance + 6 * by_directions.standard_error) << found.ids().names[i];
      EXPECT_LE(by_directions.standard_error, kTolerance);
    }
  }
}

// A promise has no room for leaks, and an estimate has lines that end on backs, whatever the seed.
TEST(SurveyOutside, LeaksOfFarAwayPartsHaveLines) {
  const Scene scene = buildScene(farAwayPairs(false));
  for (const uint64_t seed : {1, 2, 3}) {
    Request request;
    request.by = By::polygon, request.seed = seed;
    request.goal = Tolerance{1e-2};
    const FormFactors found = computeFormFactors(scene, request).form_factors;
    EXPECT_FALSE(found.hasIntervals());
    for (uint32_t i = 0; i < found.ids().count(); ++i) {
      const double leak = found.ids().names[i].starts_with("low") ? kOfSquares : 0;
      EXPECT_NEAR(found.formFactor(i, kLeak).value, leak, 1e-2) << found.ids().names[i];
      EXPECT_NEAR(found.formFactor(i, kEnvironment).value, 1 - leak, 1e-2) << found.ids().names[i];
    }
  }
}

}  // namespace
}  // namespace viewpeel
