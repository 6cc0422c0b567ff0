// These tests judge how a LineRun ends.
#include <memory>
#include <vector>

#include <glm/vec3.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include "engines/host_engine.h"
#include "estimator/line_run.h"
#include "estimator/plan_lines.h"
#include "pair_lines/pair_lines.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

// Between surfaces, common directions count the small pairs here. Errors of a few directions a replicate stay far above
// the goal, however many lines the other pairs have.
TEST(LineRun, EndsAfterEightTimesTheReplicatesWhereItMissesTheGoal) {
  constexpr uint64_t kTimes = 8, kFarTooMany = 10 * kTimes;
  constexpr double kLeastFormFactor = 0.05;
  const Scene scene = buildScene(bench::roomWithBoxes(1));
  const Ids face_ids = makeIds(scene, By::polygon, false), ids = makeIds(scene, By::surface, false);
  EstimateOptions options;
  options.by = By::surface;
  options.tolerance = 1e-4;
  options.replicates = 2;
  options.directions = 2;
  PairLines lines(scene, face_ids, {}, options.seed, 2, [] {});
  std::vector<LinePair> pairs = planLines(lines, lines.find(kLeastFormFactor), face_ids, ids, options, false, INFINITY);
  const std::unique_ptr<Engine> engine = makeHostEngine(scene, face_ids, {.resolution = 64});
  LineRun run(*engine, scene, face_ids, lines, std::move(pairs), kLeastFormFactor, options);
  while (!run.isDone() && run.sums().replicateCount() < kFarTooMany * options.replicates) run.step();
  EXPECT_EQ(run.sums().replicateCount(), kTimes * options.replicates);
  EXPECT_FALSE(run.isReached());
}

// Nothing can block the two triangles, so no lines reduce the error of their form factor. A run whose goal is below
// this error says that it misses the goal.
TEST(LineRun, MissesAGoalBelowTheErrorOfUnoccludedFormFactors) {
  InputScene input{"triangles", {}, {}};
  test_scenes::addFace(input, "low", std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}});
  test_scenes::addFace(input, "high", std::vector<glm::dvec3>{{0.1, 0.1, 0.5}, {0.3, 0.9, 0.4}, {0.9, 0.2, 0.7}});
  const Scene scene = buildScene(input);
  Request request;
  request.promise = false;
  request.goal = Tolerance{1e-4};
  const Result coarse = computeFormFactors(scene, request);
  EXPECT_TRUE(coarse.goal_reached);
  const double error = coarse.largest_standard_error;
  ASSERT_GT(error, 0);
  for (const double times : {1.1, 0.9}) {
    request.goal = Tolerance{times * error};
    EXPECT_EQ(computeFormFactors(scene, request).goal_reached, times > 1) << times;
  }
}

}  // namespace
}  // namespace viewpeel
