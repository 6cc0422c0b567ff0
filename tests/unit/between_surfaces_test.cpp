// Between surfaces common directions or rays alone may take less time than finding pairs of polygons. These tests
// compare such runs with finer ones by lines, with other numbers of threads, and with runs that were stopped and
// resumed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <viewpeel/compute.h>
#include "scenes/generate.h"
#include "scenes/triangulated_city.h"
#include "tests/support/same_bits.h"

namespace viewpeel {
namespace {

constexpr double kGoal = 0.03;

// The office of 2,320 polygons and 18 surfaces, without its ceiling where it is open.
Scene office(bool is_open) {
  InputScene scene = bench::refined(loadScene(VIEWPEEL_SCENES "/office.obj"), 2);
  if (is_open)
    std::erase_if(scene.faces, [&](const InputFace& face) { return scene.surface_names[face.surface] == "ceiling"; });
  return buildScene(scene);
}

// A city of 3,000 triangles, with a sensor of 2 cm over its roofs, on which very few common lines would end.
Scene cityWithSensor() {
  InputScene scene = bench::triangulatedCity(3'000).scene;
  const auto sensor = static_cast<uint32_t>(scene.surface_names.size());
  scene.surface_names.insert(scene.surface_names.end(), {"sensor", "sensor_top"});
  const glm::dvec3 p(50, 50, 90), q(50.02, 50, 90), r(50, 50.02, 90);
  scene.faces.push_back({{p, r, q}, sensor});
  scene.faces.push_back({{p, q, r}, sensor + 1});
  return buildScene(scene);
}

// Returns the largest difference of form factors, from the smaller surface of each pair.
double largestDifference(const FormFactors& found, const FormFactors& truth) {
  double largest = 0;
  for (const FormFactors::Entry& entry : truth.entries())
    largest = std::max(largest, std::abs(found.exchangeArea(entry.i, entry.j).value - entry.exchange_area.value) /
                                    truth.ids().smallerArea(entry.i, entry.j));
  return largest;
}

Request requestFor(double tolerance) {
  Request request;
  request.by = By::surface;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.threads = 2;
  return request;
}

TEST(BetweenSurfaces, ErrorsKeepToTheTolerance) {
  for (const bool is_open : {false, true}) {
    SCOPED_TRACE(is_open ? "open" : "closed");
    const Scene scene = office(is_open);
    const Result found = computeFormFactors(scene, requestFor(kGoal));
    EXPECT_FALSE(found.plan.pair_lines);
    EXPECT_TRUE(found.plan.aims_at_largest_error);
    EXPECT_NE(found.plan.no_pair_lines.find("common directions take less time"), std::string::npos);
    EXPECT_TRUE(found.goal_reached);
    Request fine = requestFor(kGoal / 30);
    fine.pair_lines = true;
    const double largest = largestDifference(found.form_factors, computeFormFactors(scene, fine).form_factors);
    EXPECT_LE(largest, kGoal);
    EXPECT_GT(largest, kGoal / 30);  // no more directions than the goal asks for
  }
}

TEST(BetweenSurfaces, BitsDependOnSeedsAlone) {
  const Scene scene = office(false);
  Request request = requestFor(kGoal);
  const FormFactors one = computeFormFactors(scene, request).form_factors;
  request.threads = 3;
  expectSameBits(computeFormFactors(scene, request).form_factors, one);
  request.seed = 2;
  EXPECT_NE(computeFormFactors(scene, request).form_factors.exchangeArea(0, 1).value, one.exchangeArea(0, 1).value);
}

// The goal of the resumed run is about the largest error, too.
TEST(BetweenSurfaces, GoesOnFromACheckpoint) {
  const Scene scene = office(false);
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "between_surfaces.h5";
  FormFactorRun whole(scene, requestFor(kGoal)), second(scene, requestFor(kGoal));
  whole.makePlan();
  for (int replicate = 0; replicate < 3; ++replicate) whole.step();
  whole.writeCheckpoint(file);
  while (!whole.isDone()) whole.step();
  second.resumeFrom(file);
  second.makePlan();
  EXPECT_TRUE(second.plan().aims_at_largest_error);
  while (!second.isDone()) second.step();
  expectSameBits(second.result().form_factors, whole.result().form_factors);
  std::filesystem::remove(file);
}

TEST(BetweenSurfaces, ErrorsOfRaysAloneKeepToTheTolerance) {
  const Scene scene = cityWithSensor();
  const Result found = computeFormFactors(scene, requestFor(kGoal));
  ASSERT_TRUE(found.plan.pair_lines);
  EXPECT_EQ(found.plan.pair_lines->least_form_factor, 1);
  EXPECT_TRUE(found.plan.pair_lines->has_rays);
  EXPECT_EQ(found.lines, 0u);
  EXPECT_TRUE(found.goal_reached);
  Request fine = requestFor(kGoal / 30);
  fine.pair_lines = true;
  const FormFactors truth = computeFormFactors(scene, fine).form_factors;
  const double largest = largestDifference(found.form_factors, truth);
  EXPECT_LE(largest, kGoal);
  EXPECT_GT(largest, kGoal / 30);  // no more rays than the goal asks for
  // Of form factors above the bound on pairs that no ray met, one in twenty may be missing.
  size_t large = 0, missing = 0;
  for (const FormFactors::Entry& entry : truth.entries()) {
    if (entry.j >= kEnvironment) continue;
    if (entry.exchange_area.value / truth.ids().smallerArea(entry.i, entry.j) < found.unmet_bound) continue;
    ++large, missing += !(found.form_factors.exchangeArea(entry.i, entry.j).value > 0);
  }
  EXPECT_GT(large, 20u);
  EXPECT_LE(double(missing), 0.05 * double(large));
}

TEST(BetweenSurfaces, BitsOfRaysAloneDependOnSeedsAlone) {
  const Scene scene = cityWithSensor();
  Request request = requestFor(kGoal);
  const FormFactors one = computeFormFactors(scene, request).form_factors;
  request.threads = 3;
  expectSameBits(computeFormFactors(scene, request).form_factors, one);
}

// A finer goal than the checkpoint's has more replicates of the same rays.
TEST(BetweenSurfaces, RaysAloneGoOnFromACheckpoint) {
  const Scene scene = cityWithSensor();
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "rays_alone.h5";
  FormFactorRun whole(scene, requestFor(kGoal)), second(scene, requestFor(kGoal)), finer(scene, requestFor(kGoal / 2));
  whole.makePlan();
  for (int replicate = 0; replicate < 3; ++replicate) whole.step();
  whole.writeCheckpoint(file);
  while (!whole.isDone()) whole.step();
  second.resumeFrom(file);
  while (!second.isDone()) second.step();
  expectSameBits(second.result().form_factors, whole.result().form_factors);
  finer.resumeFrom(file);
  while (!finer.isDone()) finer.step();
  EXPECT_TRUE(finer.result().goal_reached);
  EXPECT_GT(finer.result().replicates, whole.result().replicates);
  std::filesystem::remove(file);
}

// Lines are drawn for fine goals, which they reach sooner, and on request.
TEST(BetweenSurfaces, LinesArePlannedForFineGoals) {
  const Scene scene = office(false);
  FormFactorRun fine(scene, requestFor(kGoal / 30));
  fine.makePlan();
  EXPECT_TRUE(fine.plan().pair_lines);
  Request request = requestFor(kGoal);
  request.pair_lines = true;
  FormFactorRun with_lines(scene, request);
  with_lines.makePlan();
  EXPECT_TRUE(with_lines.plan().pair_lines);
}

}  // namespace
}  // namespace viewpeel
