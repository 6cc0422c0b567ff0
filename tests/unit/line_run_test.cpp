// These tests judge how a LineRun ends.
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "engines/host_engine.h"
#include "estimator/line_run.h"
#include "estimator/plan_lines.h"
#include "pair_lines/pair_lines.h"
#include "scenes/generate.h"

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

}  // namespace
}  // namespace viewpeel
