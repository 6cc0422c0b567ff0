// In rough estimates of open scenes each polygon has rays of its own, and large pairs have lines. These tests compare
// such a run with a finer one by lines alone, with other numbers of threads, and with one that was stopped and resumed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <viewpeel/compute.h>

#include "estimator/line_mixture.h"
#include "estimator/plan_lines.h"
#include "scenes/triangulated_city.h"
#include "sums/line_form_factors.h"
#include "sums/replicate_sums.h"

namespace viewpeel {
namespace {

constexpr double kGoal = 0.1;

Scene city() { return buildScene(bench::triangulatedCity(1'000).scene); }

Request requestFor(double tolerance, size_t threads = 2) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.threads = static_cast<uint32_t>(threads);
  return request;
}

void expectSameBits(const FormFactors& a, const FormFactors& b) {
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value);
    EXPECT_EQ(a.entries()[k].exchange_area.standard_error, b.entries()[k].exchange_area.standard_error);
  }
}

TEST(RayMixture, PaysWhereTheGoalIsRoughAndPairsAreMany) {
  EstimateOptions options;
  options.tolerance = 0.03;
  const LineMixture mixture = rayMixtureFor(options, 6'604);
  EXPECT_TRUE(mixture.has_rays);
  EXPECT_DOUBLE_EQ(mixture.least_form_factor, 0.03 / kMostOfCounted);
  EXPECT_EQ(mixture.directions % 16, 0);
  options.tolerance = 0.003;
  EXPECT_GT(rayMixtureFor(options, 6'604).directions, 10 * mixture.directions);
  // Pairs of the cities of 1,016, 6,604 and 19,994 triangles. Lines for all took 0.6, 17 and 183 s of CPU time, rays
  // 9.5 s in the second city at 0.03, and 84 s in the third one at 0.01.
  const PairNumbers small{1.2e5, 7.6e4, 5e2, 4.4e4}, medium{4.2e6, 2.0e6, 2e4, 1.5e6}, large{4.5e7, 1.1e7, 2e5, 9e6};
  EXPECT_TRUE(paysRays(medium, mixture, 8, 6'604));
  EXPECT_FALSE(paysRays(small, mixture, 8, 1'016));
  options.tolerance = 0.01;
  EXPECT_FALSE(paysRays(medium, rayMixtureFor(options, 6'604), 8, 6'604));
  EXPECT_TRUE(paysRays(large, rayMixtureFor(options, 19'994), 8, 19'994));
  EXPECT_FALSE(paysRays({100, 100, 10, 10}, mixture, 8, 16));  // lines take no time
  options.tolerance = 1e-4;
  EXPECT_TRUE(paysRays({2e8, 1e8, 1e6, 1e7}, rayMixtureFor(options, 50'000), 8, 50'000));  // too many pairs for lines
}

TEST(RayMixture, ErrorsKeepToTheToleranceAndAreWellStated) {
  const Scene scene = city();
  const Result found = computeFormFactors(scene, requestFor(kGoal));
  ASSERT_TRUE(found.plan.pair_lines && found.plan.pair_lines->has_rays);
  EXPECT_TRUE(found.goal_reached);
  const FormFactors truth = computeFormFactors(scene, requestFor(kGoal / 100)).form_factors;
  const Ids& ids = truth.ids();
  double largest = 0, squares = 0;
  size_t count = 0;
  for (const FormFactors::Entry& entry : truth.entries()) {
    const Measured value = found.form_factors.exchangeArea(entry.i, entry.j);
    const double error = std::abs(value.value - entry.exchange_area.value) / ids.smallerArea(entry.i, entry.j);
    largest = std::max(largest, error);
    if (entry.j != kEnvironment) continue;
    squares += std::pow((value.value - entry.exchange_area.value) / value.standard_error, 2), ++count;
  }
  EXPECT_LE(largest, kGoal);
  // Errors of environments over their standard errors have a mean square near 1: with few replicates somewhat above,
  // and below it where the surplus for unmet rays counts. Their standard deviation is sqrt(2 / 1,016) = 0.044.
  EXPECT_GT(squares / double(count), 0.5);
  EXPECT_LT(squares / double(count), 1.5);
}

TEST(RayMixture, BitsDependOnSeedsAlone) {
  const Scene scene = city();
  const FormFactors one = computeFormFactors(scene, requestFor(kGoal, 1)).form_factors;
  expectSameBits(computeFormFactors(scene, requestFor(kGoal, 3)).form_factors, one);
  Request other = requestFor(kGoal);
  other.seed = 2;
  EXPECT_NE(computeFormFactors(scene, other).form_factors.exchangeArea(0, kEnvironment).value,
            one.exchangeArea(0, kEnvironment).value);
}

TEST(RayMixture, IsNotForTwoSidedPolygons) {
  Request request = requestFor(kGoal);
  request.two_sided = true;
  const Result found = computeFormFactors(city(), request);
  EXPECT_FALSE(found.plan.pair_lines && found.plan.pair_lines->has_rays);
}

// All rays of a polygon that looks up leave the scene. A polygon might see something that a few more rays would meet.
TEST(RayMixture, AnEnvironmentThatAllRaysReachIsNotCertain) {
  Ids ids;
  ids.names = {"up"}, ids.areas = {2.0}, ids.surface = {0};
  ReplicateSums sums(ids);
  sums.countRays();
  constexpr uint64_t kRays = 128, kCounts = 1'000;  // of a ray
  for (int replicate = 0; replicate < 8; ++replicate) sums.add({{0, kEnvironment, kRays * kCounts, 0}});
  const double unit = 2.0 / (2 * kCounts);  // A ray stands for the area 2, and 2 counts for a unit.
  const FormFactors found = sums.formFactors(unit / kRays, unit);
  ASSERT_EQ(found.entries().size(), 1u);
  EXPECT_NEAR(found.entries()[0].exchange_area.value, 2, 1e-12);
  EXPECT_NEAR(found.entries()[0].exchange_area.standard_error / 2, 1.0 / (8 * kRays), 0.1 / (8 * kRays));
}

}  // namespace
}  // namespace viewpeel
