// A run whose goal is a time takes the lines, rays or directions that fit into it. What these tests assert holds on
// machines of any speed: most times are far too short for any plan, or far longer than the finest plan takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "reference/closed_forms/past_blocker.h"
#include "run/rules.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"
#include "sums/line_form_factors.h"
#include "tests/support/same_bits.h"
#include <viewpeel/compute.h>
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kTooShort = 1e-3, kLong = 1e5;  // s

Request inTime(double seconds) {
  Request request;
  request.goal = Seconds{seconds};
  request.engine = EngineKind::host;
  request.threads = 2;
  return request;
}

PlanSummary planOf(const Scene& scene, const Request& request) {
  FormFactorRun run(scene, request);
  return run.makePlan();
}

Scene city() { return buildScene(bench::triangulatedCity(1'000).scene); }

// A long time gives all pairs lines. In a short one only large pairs have them, beside the coarsest rays of an open
// scene, or beside common directions of a closed one.
TEST(TimedRun, TheTimeChoosesTheMixture) {
  constexpr double kCoarsest = kCoarsestTimed / kMostOfCounted;
  for (const bool is_open : {true, false}) {
    SCOPED_TRACE(is_open);
    const Scene scene = is_open ? city() : buildScene(bench::roomWithBoxes(1));
    const PlanSummary coarse = planOf(scene, inTime(kTooShort)), fine = planOf(scene, inTime(kLong));
    ASSERT_TRUE(coarse.pair_lines && fine.pair_lines);
    EXPECT_DOUBLE_EQ(coarse.pair_lines->least_form_factor, kCoarsest);
    EXPECT_EQ(coarse.pair_lines->has_rays, is_open);
    EXPECT_EQ(fine.pair_lines->least_form_factor, 0);
    EXPECT_FALSE(coarse.no_promise.empty());
  }
}

// Where the mixture does not suit, common directions count: between surfaces of an open scene, for a question, where a
// checkpoint may go on to a finer goal, and in parts of a run, which must have one plan.
TEST(TimedRun, OthersHaveCommonDirections) {
  const Scene scene = city();
  constexpr double kEnoughForLines = 2;
  Request by_surface = inTime(kEnoughForLines), question = inTime(kTooShort), checkpoint = inTime(kTooShort),
          part = inTime(kEnoughForLines);
  by_surface.by = By::surface;
  question.question.from = {scene.surfaces.front().name};
  checkpoint.lines_for_all = true;
  part.amount.is_exact = true;
  EXPECT_FALSE(planOf(scene, by_surface).pair_lines);
  EXPECT_FALSE(planOf(scene, question).pair_lines);
  EXPECT_FALSE(planOf(scene, checkpoint).pair_lines);
  EXPECT_FALSE(planOf(scene, part).pair_lines);
  by_surface.pair_lines = true;
  EXPECT_TRUE(planOf(scene, by_surface).pair_lines);
}

// A time that is over at once still has two replicates, and reaches its goal. A later run goes on from its checkpoint,
// but not to a tolerance for which more pairs would have lines.
TEST(TimedRun, HasTwoReplicatesAndGoesOn) {
  const Scene scene = city();
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "viewpeel_timed_run_test.checkpoint";
  FormFactorRun first(scene, inTime(kTooShort));
  while (!first.isDone()) first.step();
  EXPECT_EQ(first.result().replicates, 2u);
  EXPECT_TRUE(first.result().goal_reached);
  first.writeCheckpoint(file);
  const auto resume = [&](const Goal& goal) {
    Request request = inTime(kTooShort);
    request.goal = goal;
    FormFactorRun run(scene, request);
    run.resumeFrom(file);
    while (!run.isDone()) run.step();
    return run.result();
  };
  EXPECT_EQ(resume(Seconds{kTooShort}).replicates, 3u);
  EXPECT_GE(resume(Tolerance{kCoarsestTimed}).replicates, 8u);
  EXPECT_THROW(resume(Tolerance{kCoarsestTimed / 2}), Error);
  std::filesystem::remove(file);
}

// With time to spare a run ends where nothing is in doubt: here nothing blocks the pair.
TEST(TimedRun, EndsWhereAllIsExact) {
  const Result result = computeFormFactors(buildScene(ts::parallelSquares()), inTime(kLong));
  EXPECT_TRUE(result.goal_reached);
  EXPECT_LT(result.largest_standard_error, 1e-9);
  EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, 0.1998248957, 1e-7);  // Howell, C-11
}

// Further replicates are as large as all before them, and errors stay honest: chance exceeds 6 of them in less than 1
// of 1,000 runs (Student, 7 degrees of freedom).
TEST(TimedRun, FurtherLinesFollowTheErrors) {
  const InputScene input = ts::squaresPastABlocker();
  const std::vector<InputFace>& faces = input.faces;
  const double truth = reference::formFactorPastBlocker(faces[0].corners, faces[1].corners, faces[2].corners).value;
  const Result result = computeFormFactors(buildScene(input), inTime(0.3));
  const Measured f = result.form_factors.formFactor(0, 1);
  EXPECT_GT(f.standard_error, 0);
  EXPECT_NEAR(f.value, truth, 6 * f.standard_error + reference::kPastBlockerError);
}

// Where the next replicate would end after the limit beside a tolerance, it has fewer lines, as for a coarser goal. The
// run has not reached its own goal then.
TEST(TimedRun, FewerLinesDoNotReachTheGoal) {
  Request request = inTime(kTooShort);
  request.goal = Tolerance{kFinestTimed};
  request.time_limit_s = 1;
  const Scene scene = buildScene(bench::roomWithBoxes(1));
  FormFactorRun run(scene, request);
  while (!run.isDone()) run.step();
  EXPECT_FALSE(run.result().goal_reached);
}

}  // namespace
}  // namespace viewpeel
