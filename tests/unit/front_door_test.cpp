// The one call behind program and library: against closed forms, in steps, stopped, gone on with, refused.
#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>

#include "reference/exact/exact_engine.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kParallelSquares = 0.1998248957;  // Howell, C-11

Request onHost(Goal goal) {
  Request request;
  request.goal = goal;
  request.engine = EngineKind::host;
  return request;
}

void expectSameBits(const FormFactors& a, const FormFactors& b) {
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value) << k;
    EXPECT_EQ(a.entries()[k].exchange_area.standard_error, b.entries()[k].exchange_area.standard_error) << k;
  }
}

// Each goal comes to the closed form, with what it promises. Squares that nothing blocks are exact by default; without
// unoccluded form factors they lie within 6 standard errors of 8 or more replicates, which chance passes in less than 1
// of 1,000 runs (Student, 7 degrees of freedom).
TEST(FrontDoor, EveryGoalIsReached) {
  const Scene scene = buildScene(ts::parallelSquares());
  for (const Goal& goal : {Goal(Tolerance{2e-3}), Goal(Tolerance{1e-2, 0.05}), Goal(Relative{0.05}), Goal(Seconds{0.5}),
                           Goal(FixedAmount{.directions = 64, .resolution = 64})}) {
    for (const bool unoccluded : {true, false}) {
      SCOPED_TRACE(testing::Message() << "goal " << goal.index() << (unoccluded ? ", unoccluded form factors" : ""));
      Request request = onHost(goal);
      request.unoccluded = unoccluded;
      const Result result = computeFormFactors(scene, request);
      const Measured f = result.form_factors.formFactor(0, 1);
      EXPECT_NEAR(f.value, kParallelSquares, unoccluded ? 1e-7 : 6 * f.standard_error);
      EXPECT_FALSE(result.interrupted);
      EXPECT_EQ(result.plan.unoccluded, unoccluded);
      EXPECT_EQ(result.directions, result.replicates * result.plan.directions);
      const auto* tolerance = std::get_if<Tolerance>(&goal);
      EXPECT_LE(result.largest_standard_error, tolerance ? tolerance->standard_error : INFINITY);
      EXPECT_LE(result.largest_relative_error, std::holds_alternative<Relative>(goal) ? 0.05 : INFINITY);
      EXPECT_NEAR(result.environment_share, 1 - kParallelSquares, 0.02);
      EXPECT_EQ(result.leak_share, 0);
    }
  }
}

TEST(FrontDoor, AGuaranteeSaysWhatHolds) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Result result = computeFormFactors(scene, onHost(EpsilonDelta{.epsilon = 0.1, .delta = 0.1}));
  ASSERT_TRUE(result.guarantee && result.plan.guarantee);
  EXPECT_LE(result.guarantee->bound, 0.1);
  EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, kParallelSquares, 0.1);
  EXPECT_EQ(result.directions, result.replicates * result.plan.guarantee->block_directions);
}

// The caller's exact engine: 2 x 400 exact projections, no lattice. Without one the kind is refused.
TEST(FrontDoor, TheExactEngineIsBrought) {
  const Scene scene = buildScene(ts::parallelSquares());
  Request request{.goal = FixedAmount{.directions = 400}, .engine = EngineKind::exact};
  EXPECT_THROW(computeFormFactors(scene, request), Error);
  request.exact_engine = reference::exactEngines();
  const Result result = computeFormFactors(scene, request);
  const Measured f = result.form_factors.formFactor(0, 1);
  EXPECT_NEAR(f.value, kParallelSquares, 6 * f.standard_error);
  EXPECT_EQ(result.plan.device, "none");
}

// Four replicates, kept, and four more are eight; with the plan of the first, though the second has no amounts.
TEST(FrontDoor, GoesOnFromACheckpoint) {
  const Scene scene = buildScene(ts::squaresPastAnEdge());
  const std::filesystem::path file = testing::TempDir() + "front_door.h5";
  for (const bool unoccluded : {true, false}) {
    Request request = onHost(FixedAmount{.directions = 64, .resolution = 64});
    request.unoccluded = unoccluded;
    const Result whole = computeFormFactors(scene, request);
    FormFactorRun first(scene, request);
    while (first.replicateCount() < 4) first.step();
    EXPECT_FALSE(first.isDone());
    EXPECT_EQ(first.resultSoFar().replicates, 4u);
    first.writeCheckpoint(file);
    Request again = onHost(Tolerance{1});
    again.unoccluded = unoccluded;
    FormFactorRun second(scene, again);
    EXPECT_EQ(second.resumeFrom(file), "0 to 3");
    while (!second.isDone()) second.step();
    const Result result = second.result();
    EXPECT_EQ(result.replicates, 8u);
    EXPECT_EQ(result.plan.directions, 64u);
    expectSameBits(result.form_factors, whole.form_factors);
    again.seed = 2;
    FormFactorRun other(scene, again);
    EXPECT_THROW(other.resumeFrom(file), Error);
  }
  std::filesystem::remove(file);
}

// Whenever the observer says so: before anything is counted there is nothing, afterwards what was counted.
TEST(FrontDoor, StopsOnRequest) {
  const Scene scene = buildScene(ts::parallelSquares());
  for (const uint64_t replicates : {0, 3}) {
    uint64_t done = 0, calls = 0;
    bool counts = false;
    Observer observer;
    observer.should_stop = [&] { return done >= replicates; };
    observer.on_progress = [&](const Progress& progress) { done = progress.replicates; };
    observer.on_count = [&](bool begins) {
      EXPECT_NE(counts, begins);
      counts = begins;
      ++calls;
    };
    const Result result = computeFormFactors(scene, onHost(FixedAmount{.directions = 16, .replicates = 8}), observer);
    EXPECT_TRUE(result.interrupted);
    EXPECT_EQ(result.replicates, replicates);
    EXPECT_EQ(result.form_factors.entries().empty(), replicates == 0);
    EXPECT_FALSE(counts);
    EXPECT_GE(calls, 2 * replicates);
  }
}

// Closure where there is one, and its refusal beside what was measured where there is none.
TEST(FrontDoor, BalanceOrWhyThereIsNone) {
  Request request = onHost(FixedAmount{.directions = 200, .resolution = 64});
  request.balance = true;
  const Result room = computeFormFactors(buildScene(ts::insideOfCube()), request);
  ASSERT_TRUE(room.balanced);
  EXPECT_FALSE(room.balance_refusal);
  for (const Measured& sum : room.balanced->form_factors.rowSums()) EXPECT_NEAR(sum.value, 1, kBalanceTolerance);
  const Result open = computeFormFactors(buildScene(ts::parallelSquares()), request);
  EXPECT_FALSE(open.balanced);
  ASSERT_TRUE(open.balance_refusal);
  EXPECT_GT(open.form_factors.formFactor(0, 1).value, 0);
}

TEST(FrontDoor, ContradictionsAreRefused) {
  const auto refusal = [](const Request& request) -> std::string {
    try {
      checkRequest(request);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_NE(refusal({.goal = EpsilonDelta{.epsilon = 1}}).find("between 0 and 1"), std::string::npos);
  EXPECT_NE(refusal({.goal = EpsilonDelta{}, .amount = {.directions = 64}}).find("plans for itself"),
            std::string::npos);
  EXPECT_NE(refusal({.goal = EpsilonDelta{.range = 3}, .amount = {.resolution = 64}}).find("one of the two"),
            std::string::npos);
  EXPECT_NE(refusal({.goal = EpsilonDelta{.statistic = Statistic::median, .block_directions = 4}}).find("not blocks"),
            std::string::npos);
  EXPECT_NE(refusal({.goal = FixedAmount{.finest = 128}}).find("--finest"), std::string::npos);
  EXPECT_NE(refusal({.question = {.from = {"floor"}}, .unoccluded = true}).find("whole matrix"), std::string::npos);
  EXPECT_NE(refusal({.question = {.from = {"floor"}}, .balance = true}).find("every row"), std::string::npos);
}

}  // namespace
}  // namespace viewpeel
