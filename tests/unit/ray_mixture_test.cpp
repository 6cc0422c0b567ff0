// In rough estimates of open scenes each polygon has rays of its own, and large pairs have lines. These tests compare
// such a run with a finer one by lines alone, with other numbers of threads, and with one that was stopped and resumed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/support/same_bits.h"
#include <viewpeel/compute.h>

#include "estimator/line_mixture.h"
#include "scenes/generate.h"
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

TEST(RayMixture, PaysWhereTheGoalIsRoughAndPairsAreMany) {
  EstimateOptions options;
  options.tolerance = 0.03;
  const LineMixture mixture = rayMixtureFor(options, 6'604);
  EXPECT_TRUE(mixture.has_rays);
  EXPECT_DOUBLE_EQ(mixture.least_form_factor, 0.03 / kMostOfCounted);
  EXPECT_EQ(mixture.directions % 16, 0);
  options.tolerance = 0.003;
  EXPECT_GT(rayMixtureFor(options, 6'604).directions, 10 * mixture.directions);
  // PairLines::estimatePairs finds these numbers in the cities of 1,016, 6,604 and 19,994 triangles, for pairs above
  // 0.01, 0.01 and 0.0033. Lines for all pairs took 0.6, 17 and 183 s of CPU time, rays 9.5 s in the second city at
  // 0.03, and 84 s in the third one at 0.01.
  const PairNumbers small{9.95e4, 7.77e4, 4.66e3, 4.32e4}, medium{5.37e6, 2.23e6, 3.73e4, 1.73e6},
      large{5.15e7, 1.09e7, 4.88e5, 9.42e6};
  EXPECT_TRUE(paysRays(medium, mixture, 8, 6'604));
  EXPECT_FALSE(paysRays(small, mixture, 8, 1'016));
  options.tolerance = 0.01;
  EXPECT_FALSE(paysRays(medium, rayMixtureFor(options, 6'604), 8, 6'604));
  EXPECT_TRUE(paysRays(large, rayMixtureFor(options, 19'994), 8, 19'994));
  EXPECT_FALSE(paysRays({100, 100, 10, 10}, mixture, 8, 16));  // lines take no time
  PairNumbers of_parts = medium;
  of_parts.small_of_parts = of_parts.found - of_parts.large;  // the search leaves out no pair
  EXPECT_FALSE(paysRays(of_parts, mixture, 8, 6'604));
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
  // Errors of environments over their standard errors have a mean square of 1.3 for R = 9 replicates (Student, R - 1
  // degrees of freedom), up to 0.1 more or less by chance, and below it where the surplus for unmet rays counts.
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

TEST(RayMixture, GoesOnFromACheckpoint) {
  const Scene scene = city();
  FormFactorRun whole(scene, requestFor(kGoal));
  whole.makePlan();
  ASSERT_TRUE(whole.plan().pair_lines && whole.plan().pair_lines->has_rays);
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "ray_mixture.h5";
  for (int k = 0; k < 3; ++k) whole.step();
  whole.writeCheckpoint(file);
  while (!whole.isDone()) whole.step();
  FormFactorRun second(scene, requestFor(kGoal));
  second.resumeFrom(file);
  second.makePlan();
  EXPECT_TRUE(second.plan().pair_lines && second.plan().pair_lines->has_rays);
  while (!second.isDone()) second.step();
  std::filesystem::remove(file);
  expectSameBits(second.result().form_factors, whole.result().form_factors);
}

// Lines for all pairs of this open room do not fit into memory. Two-sided polygons have no rays, and the plan says why
// they have no pair lines.
TEST(RayMixture, IsForOpenScenesOfManyPairs) {
  constexpr double kFineGoal = 1e-2;
  InputScene room = bench::roomWithBoxes(5);
  std::erase_if(room.faces, [](const InputFace& face) {
    return std::ranges::all_of(face.corners, [](const glm::dvec3& corner) { return corner.z > 2.9; });
  });
  const Scene scene = buildScene(room);
  ASSERT_GT(scene.faces.size(), 8'000u);
  Request request;
  request.goal = Tolerance{kFineGoal};
  FormFactorRun run(scene, request);
  run.makePlan();
  ASSERT_TRUE(run.plan().pair_lines);
  EXPECT_TRUE(run.plan().pair_lines->has_rays);
  EXPECT_EQ(run.plan().pair_lines->least_form_factor, kFineGoal / kMostOfCounted);
  EXPECT_NE(run.plan().no_promise.find("twice the time of rays"), std::string::npos) << run.plan().no_promise;
  request.two_sided = true;
  FormFactorRun two_sided(scene, request);
  two_sided.makePlan();
  EXPECT_FALSE(two_sided.plan().pair_lines);
  EXPECT_NE(two_sided.plan().no_promise.find("lines leave the scene"), std::string::npos)
      << two_sided.plan().no_promise;
  EXPECT_EQ(two_sided.plan().no_pair_lines, two_sided.plan().no_promise);
}

// For a rough goal rays are quicker, and lines for all pairs would be much finer than it. A request for pair lines gets
// lines for all pairs. Two-sided polygons have common directions alone.
TEST(RayMixture, IsForRoughGoalsOfLargeOpenScenes) {
  constexpr double kRoughGoal = 0.05;
  const Scene scene = buildScene(bench::city(8'600));
  Request request;
  request.goal = Tolerance{kRoughGoal};
  FormFactorRun run(scene, request);
  run.makePlan();
  ASSERT_TRUE(run.plan().pair_lines);
  EXPECT_TRUE(run.plan().pair_lines->has_rays);
  request.pair_lines = true;
  FormFactorRun with_lines(scene, request);
  with_lines.makePlan();
  ASSERT_TRUE(with_lines.plan().pair_lines);
  EXPECT_FALSE(with_lines.plan().pair_lines->has_rays);
  EXPECT_EQ(with_lines.plan().pair_lines->least_form_factor, 0);
  request.pair_lines.reset();
  request.two_sided = true;
  FormFactorRun two_sided(scene, request);
  two_sided.makePlan();
  EXPECT_FALSE(two_sided.plan().pair_lines);
  EXPECT_NE(two_sided.plan().no_pair_lines.find("the tolerance is above 0.02"), std::string::npos)
      << two_sided.plan().no_pair_lines;
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
