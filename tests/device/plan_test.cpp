// These tests compare predictions of a plan with the run. They also check that a plan names every row that it hardly
// covers.
#include <cmath>

#include <gtest/gtest.h>

#include "engines/host_engine.h"
#include "estimator/plan.h"
#include "estimator/find_prior.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

Lattices latticesWithWindows() { return {enginesOf(EngineKind::compute), {}, 0, true}; }

// A run reaches about the planned error. The largest standard error of 8 replicates is predicted from 8 others. Both
// squares have 7 degrees of freedom, and F(7, 7) stays below 10^2 with probability 1 - 1e-6. Interpolation between
// pilots may add a factor of 2.
TEST(Plan, PredictsTheStandardError) {
  for (const InputScene& input : {ts::parallelSquares(), ts::insideOfCube(), ts::roomWithTouchingBoxes()})
    for (double tolerance : {0.02, 0.002}) {
      const Scene scene = buildScene(input);
      const Ids ids = makeIds(scene, By::surface, false);
      EstimateOptions options{.tolerance = tolerance};
      const Plan plan = planEstimate(scene, ids, options, latticesWithWindows());
      EXPECT_LE(plan.standard_error, tolerance);
      EXPECT_GT(plan.seconds, 0);
      options.directions = plan.directions;
      options.tolerance.reset();
      const Estimate estimate = estimateFormFactors(*plan.engine, scene, ids, options);
      EXPECT_LT(estimate.largest_standard_error, 20 * plan.standard_error) << input.file << " " << tolerance;
      EXPECT_GT(estimate.largest_standard_error, plan.standard_error / 20) << input.file << " " << tolerance;
    }
}

// Few lines meet each pair of small parts of a room. With unoccluded form factors the run reaches about the planned
// error. These standard errors follow from lines by chance and not from the spread of replicates, so the largest of
// many varies by less than a factor of 2. Interpolation may add another 2.
TEST(Plan, PredictsErrorsOfVisibilitiesFromFewLines) {
  InputScene input{"room in parts", {"room"}, {}};
  constexpr int kCuts = 5;
  for (const InputFace& face : ts::roomWithTouchingBoxes().faces) {
    ASSERT_EQ(face.corners.size(), 4u);
    const glm::dvec3 u = (face.corners[1] - face.corners[0]) / double(kCuts),
                     v = (face.corners[3] - face.corners[0]) / double(kCuts);
    for (int column = 0; column < kCuts; ++column)
      for (int row = 0; row < kCuts; ++row)
        input.faces.push_back({ts::parallelogram(face.corners[0] + double(column) * u + double(row) * v, u, v), 0, 0});
  }
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const Lattices lattices{enginesOf(EngineKind::host), {.count_blocked = true}, 0, false, &ids};
  for (double tolerance : {1e-3, 3e-4}) {
    EstimateOptions options{.tolerance = tolerance};
    const Plan plan = planEstimate(scene, ids, options, lattices);
    EXPECT_LE(plan.standard_error, tolerance);
    options.directions = plan.directions;
    options.tolerance.reset();
    FaceExchanges exchanges(nullptr, scene, ids);
    const FoundPrior found =
        findPrior(*plan.engine, exchanges, scene, ids, plan.groups, options, {choosePriorPilot(options).directions});
    options.prior = &found.prior;
    const double reached = estimateFormFactors(*plan.engine, scene, ids, options).largest_standard_error;
    EXPECT_LT(reached, 4 * plan.standard_error) << tolerance;
    EXPECT_GT(reached, plan.standard_error / 4) << tolerance;
  }
}

// The lattice of the first pilot hardly meets this strip. Only a finer lattice shows the variance that directions add.
// A run that was planned without a finer lattice took 3,062 replicates. With 6 degrees of freedom a variance is
// estimated below a 20th of its value with probability 1e-4. So errors are below 4.5 times the predicted ones, and
// interpolation may add a factor of 2.
TEST(Plan, CoarseLatticesDoNotHideWhatDirectionsAdd) {
  InputScene input{"strip over a square", {}, {}};
  ts::addFace(input, "square", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  ts::addFace(input, "strip", ts::parallelogram({0, 0.49995, 0.5}, {0, 1e-4, 0}, {1, 0, 0}));
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  const Lattices lattices{enginesOf(EngineKind::host), {.count_blocked = true}, 0, true, &ids};
  EstimateOptions options{.tolerance = 3e-4};
  const Plan plan = planEstimate(scene, ids, options, lattices);
  options = {.directions = plan.directions, .replicates = 32};
  FaceExchanges exchanges(nullptr, scene, ids);
  const FoundPrior found =
      findPrior(*plan.engine, exchanges, scene, ids, plan.groups, options, {choosePriorPilot(options).directions});
  options.prior = &found.prior;
  const double reached =
      2 * estimateFormFactors(*plan.engine, scene, ids, options).largest_standard_error;  // scaled to 8 replicates
  EXPECT_LT(reached, 9 * plan.standard_error) << plan.directions << " directions, " << plan.finest << " across";
}

// A finer tolerance is planned with more lattice points.
TEST(Plan, WorkGrowsWithTheTolerance) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  double points = 0;
  for (double tolerance : {0.1, 0.01, 0.001}) {
    const Plan plan = planEstimate(scene, ids, {.tolerance = tolerance}, latticesWithWindows());
    const double planned = plan.directions * std::pow(plan.groups[0].resolution, 2);
    EXPECT_GT(planned, points);
    points = planned;
  }
}

// Where the time is too short for any plan, the quickest one is taken, with a goal or without. No long pilot runs
// before.
TEST(Plan, TooLittleTimeGetsTheQuickest) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  for (const std::optional<double>& tolerance : {std::optional<double>(), std::optional(1e-12)}) {
    EstimateOptions options;
    options.tolerance = tolerance;
    options.seconds = 1e-9;
    EXPECT_EQ(planEstimate(scene, ids, options, latticesWithWindows()).directions, 16u);  // fewest directions of a plan
  }
}

// Makes a speck above the middle of a unit square, facing it.
InputScene speckOverFloor(double edge) {
  InputScene input{"speck", {}, {}};
  ts::addFace(input, "floor", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  ts::addFace(input, "speck", ts::parallelogram({0.5, 0.5, 0.1}, {0, edge, 0}, {edge, 0, 0}));
  return input;
}

// This square has 1e-8 of the area of the floor that it looks at. One lattice point in 1e4 directions would meet it, so
// it gets a window.
TEST(Plan, SmallPolygonsAreSeen) {
  const Scene scene = buildScene(speckOverFloor(1e-4));
  const Ids ids = makeIds(scene, By::polygon, false);
  EstimateOptions options{.tolerance = 0.02};
  const Plan plan = planEstimate(scene, ids, options, latticesWithWindows());
  EXPECT_GT(plan.groups.size(), 1u);
  options.directions = plan.directions;
  const Estimate estimate = estimateFormFactors(*plan.engine, scene, ids, options);
  EXPECT_LE(estimate.largest_standard_error, 0.02);
  EXPECT_LT(estimate.replicates, 100u);
  // The reference is a differential element over the middle of a square, at a tenth of its edge: four times Howell's
  // B-4 with both ratios 1/2 / 0.1.
  const double x = 0.5 / 0.1, r = std::sqrt(1 + x * x);
  const double truth = 4 / (2 * M_PI) * 2 * x / r * std::atan(x / r);
  const Measured f = estimate.form_factors.formFactor(1, 0);
  EXPECT_NEAR(f.value, truth, 5 * f.standard_error);
  EXPECT_GT(truth, 0.9);
}

// With unoccluded form factors a row's counts of one replicate must stay below 2^50. This holds for a fine window
// around a small polygon and a small tolerance too: replicates take over, or the plan says that counts are too large.
TEST(Plan, CountsAreNotTooLargeForUnoccludedFormFactors) {
  const Scene scene = buildScene(speckOverFloor(1e-5));
  const Ids ids = makeIds(scene, By::polygon, false);
  for (const bool unoccluded : {false, true}) {
    Lattices lattices = latticesWithWindows();
    lattices.lattice.count_blocked = unoccluded;
    if (unoccluded) lattices.face_ids = &ids;
    const Plan plan = planEstimate(scene, ids, {.tolerance = 1e-5, .seconds = 60}, lattices);  // pilots: 6 s at most
    const double of_row = plan.directions * ids.areas[0] / 2 / (scene.scale * scene.scale) / plan.engine->unitArea();
    EXPECT_EQ(of_row > double(kMostCounts), !unoccluded) << of_row;
    EXPECT_EQ(plan.counts_too_large, unoccluded);
  }
}

// This square has 2.5e-17 of the scene's area. In a run of this length the finest lattice meets it with less than one
// point. The plan names it, and no other polygon.
TEST(Plan, WhatMayGoUnmetIsNamed) {
  InputScene input{"speck", {}, {}};
  ts::addFace(input, "floor", {{0, 0, 0}, {2000, 0, 0}, {2000, 2000, 0}, {0, 2000, 0}});
  ts::addFace(input, "speck", {{900, 900, 1}, {900, 900.00001, 1}, {900.00001, 900.00001, 1}, {900.00001, 900, 1}});
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  EstimateOptions options{.seconds = 1e-9};  // so that the plan has the fewest directions
  EXPECT_EQ(planEstimate(scene, ids, options, latticesWithWindows()).barely_covered, std::vector<uint32_t>{1});
}

// The values that a plan prints give the same lattices again.
TEST(Plan, CanBeRepeated) {
  const Scene scene = buildScene(ts::triangleSoup(40, 0.4, 9));
  const Ids ids = makeIds(scene, By::polygon, false);
  const Plan plan = planEstimate(scene, ids, {.tolerance = 0.01}, latticesWithWindows());
  const auto again = planGroups(scene, ids, Sampling::lattice, plan.groups[0].resolution, plan.finest, plan.directions);
  ASSERT_EQ(again.size(), plan.groups.size());
  for (size_t g = 0; g < again.size(); ++g) {
    EXPECT_EQ(again[g].resolution, plan.groups[g].resolution);
    EXPECT_EQ(again[g].polygons, plan.groups[g].polygons);
  }
}

}  // namespace
}  // namespace viewpeel
