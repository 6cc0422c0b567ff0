// A goal for the root mean square of all errors: it is reached, it is true, and it takes fewer lines than a tolerance.
#include <cmath>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include "scenes/generate.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

Result computeTo(const Scene& scene, const Goal& goal, uint64_t seed, std::optional<bool> pair_lines = {}) {
  Request request;
  request.goal = goal, request.seed = seed, request.pair_lines = pair_lines, request.promise = std::nullopt;
  if (std::holds_alternative<Tolerance>(goal)) request.promise = false;
  request.engine = EngineKind::host;
  return computeFormFactors(scene, request);
}

// Returns the root mean square of the differences of all n^2 form factors.
double rmsDifference(const FormFactors& a, const FormFactors& b) {
  double squares = 0;
  const uint32_t n = a.ids().count();
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) squares += std::pow(a.formFactor(i, j).value - b.formFactor(i, j).value, 2);
  return std::sqrt(squares) / n;
}

// Returns the root mean square of the standard errors of all n^2 form factors.
double rmsError(const FormFactors& found) {
  double squares = 0;
  const uint32_t n = found.ids().count();
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) squares += std::pow(found.formFactor(i, j).standard_error, 2);
  return std::sqrt(squares) / n;
}

class RmsGoal : public testing::Test {
 protected:
  const Scene room_ = buildScene(bench::roomWithBoxes(1));
};

// The true root mean square is over 390,000 form factors. The stated one is a mean of as many variances of 7 degrees
// of freedom, some hundred of which have most of the weight. So it is off by a tenth at most, and the reference, whose
// goal is a tenth of the others', adds half a percent.
TEST_F(RmsGoal, IsTrueByLinesAndByDirections) {
  constexpr double kRmsGoal = 1e-4, kTimesOfGoal = 1.1;
  const FormFactors truth = computeTo(room_, RootMeanSquare{kRmsGoal / 10}, 100).form_factors;
  for (const bool pair_lines : {true, false}) {
    SCOPED_TRACE(pair_lines);
    const Result result = computeTo(room_, RootMeanSquare{kRmsGoal}, 1, pair_lines);
    EXPECT_TRUE(result.goal_reached);
    EXPECT_EQ(result.plan.pair_lines.has_value(), pair_lines);
    EXPECT_LE(rmsError(result.form_factors), kRmsGoal);
    EXPECT_NEAR(measureStandardErrors(result.form_factors, 0).rms_with_zeros, rmsError(result.form_factors),
                1e-12 * kRmsGoal);
    EXPECT_LE(rmsDifference(result.form_factors, truth), kTimesOfGoal * kRmsGoal);
    EXPECT_GT(rmsDifference(result.form_factors, truth), 0);
    EXPECT_FALSE(result.form_factors.hasIntervals());
  }
}

// Pairs get lines where a line lessens the sum of all squares the most. Lines for the largest error give most of them
// to few pairs: in the office a run by tolerance takes 2.4 times the lines of a run with the same root mean square.
TEST_F(RmsGoal, TakesFewerLinesThanATolerance) {
  const Scene office = loadScene(VIEWPEEL_SCENES "/office.obj");
  const Result by_tolerance = computeTo(office, Tolerance{3e-4}, 1),
               by_rms = computeTo(office, RootMeanSquare{rmsError(by_tolerance.form_factors)}, 1);
  EXPECT_TRUE(by_rms.goal_reached);
  EXPECT_LT(2 * by_rms.lines, by_tolerance.lines);
}

// Further replicates bring lines until the goal is reached: the first ones have few, for two replicates say little.
TEST_F(RmsGoal, IsReachedInScenesThatLeakAndWithTwoSides) {
  const Scene triangles = buildScene(bench::randomTriangles(100));
  for (const bool two_sided : {false, true}) {
    Request request;
    request.goal = RootMeanSquare{2e-4}, request.two_sided = two_sided, request.engine = EngineKind::host;
    const Result result = computeFormFactors(triangles, request);
    EXPECT_TRUE(result.goal_reached) << two_sided;
    EXPECT_LE(rmsError(result.form_factors), 2e-4) << two_sided;
    EXPECT_TRUE(result.plan.pair_lines) << two_sided;
  }
}

}  // namespace
}  // namespace viewpeel
