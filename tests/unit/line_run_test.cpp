// These tests judge how a LineRun ends.
#include <memory>
#include <optional>
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

// A quadrilateral of corners at two heights consists of two triangles, whose backs see each other past a plate. With
// two sides this is a form factor of the face to itself, by polygon as between surfaces. Directions are the truth.
TEST(LineRun, AFoldedFaceSeesItselfBothWays) {
  constexpr double kFoldTolerance = 1e-3, kFoldErrors = 6;
  InputScene input{"folded", {}, {}};
  test_scenes::addFace(input, "folded", std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0.8}, {1, 1, 0}, {0, 1, 0.8}});
  for (const double height : {0.5, 3.0})
    test_scenes::addFace(input, "plates",
                         test_scenes::parallelogram({0.4, 0.4, height}, {0, 0.2 * height, 0}, {0.2 * height, 0, 0}));
  const Scene scene = buildScene(input);
  const auto requestTo = [](const Goal& goal, std::optional<bool> promise, By by) {
    Request request;
    request.by = by, request.two_sided = true, request.goal = goal, request.promise = promise;
    request.engine = EngineKind::host;
    return request;
  };
  Request by_directions = requestTo(Tolerance{kFoldTolerance}, false, By::polygon);
  by_directions.pair_lines = false;
  const FormFactors truth = computeFormFactors(scene, by_directions).form_factors;
  ASSERT_GT(truth.formFactor(0, 0).value, 0.1);
  for (const Request& request : {requestTo(Tolerance{kFoldTolerance}, false, By::polygon),
                                 requestTo(Tolerance{kFoldTolerance}, true, By::polygon),
                                 requestTo(EpsilonDelta{.epsilon = kFoldTolerance}, std::nullopt, By::polygon),
                                 requestTo(Tolerance{kFoldTolerance}, false, By::surface),
                                 requestTo(Tolerance{kFoldTolerance}, true, By::surface)}) {
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.plan.pair_lines || result.plan.line_guarantee);
    for (const uint32_t id : {0u, kEnvironment}) {
      const Measured expected = truth.formFactor(0, id), found = result.form_factors.formFactor(0, id);
      EXPECT_NEAR(found.value, expected.value, kFoldTolerance + kFoldErrors * expected.standard_error) << id;
      EXPECT_NEAR(result.between_surfaces.formFactor(0, id).value, found.value, 1e-9) << id;
    }
  }
}

}  // namespace
}  // namespace viewpeel
