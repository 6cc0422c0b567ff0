// These tests call computeFormFactors() and FormFactorRun, the functions behind program and library. They compare
// results with closed forms, take single steps, stop and continue, and check refusals.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>

#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/past_blocker.h"
#include "reference/exact/exact_engine.h"
#include "scenes/named_scenes.h"
#include "scenes/random.h"
#include "scenes/stress.h"
#include "tests/support/same_bits.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kParallelSquares = 0.1998248957;  // Howell, C-11

Request onHost(Goal goal) {
  Request request;
  // These tests are about estimates; promise_test.cpp is about promises.
  if (std::holds_alternative<Tolerance>(goal)) request.promise = false;
  request.goal = goal;
  request.engine = EngineKind::host;
  return request;
}

// Each goal gives the closed form within its error. Squares that nothing blocks are exact by default, to half of the
// 1e-6 of its value that docs/method.md, section 11, promises. Without unoccluded form factors they lie within 6
// standard errors of 8 or more replicates. Chance exceeds 6 in less than 1 of 1,000 runs (Student, 7 degrees of
// freedom).
TEST(FrontDoor, EveryGoalIsReached) {
  const Scene scene = buildScene(ts::parallelSquares());
  for (const Goal& goal : {Goal(Tolerance{2e-3}), Goal(Tolerance{1e-2, 0.05}), Goal(Relative{0.05}), Goal(Seconds{0.5}),
                           Goal(RootMeanSquare{1e-3}), Goal(FixedAmount{.directions = 64, .resolution = 64})}) {
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

// Returns whether a request with this goal, after a change, is refused as bad usage.
bool isRefusedRequest(const Goal& goal, const std::function<void(Request&)>& change) {
  Request request = onHost(goal);
  change(request);
  try {
    checkRequest(request);
  } catch (const Error& error) {
    return error.code() == ErrorCode::bad_usage;
  }
  return false;
}

// checkRequest() refuses numbers without meaning, for the library has no option parser that would do so.
TEST(FrontDoor, NumbersThatMeanNothingAreRefused) {
  const auto nothing = [](Request&) {};
  EXPECT_FALSE(isRefusedRequest(Tolerance{}, nothing));
  for (const double wrong : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    EXPECT_TRUE(isRefusedRequest(Tolerance{wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(Tolerance{1e-3, wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(Relative{wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(RootMeanSquare{wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(Seconds{wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(EpsilonDelta{wrong}, nothing)) << wrong;
    EXPECT_TRUE(isRefusedRequest(Tolerance{}, [&](Request& request) { request.time_limit_s = wrong; })) << wrong;
    EXPECT_TRUE(isRefusedRequest(Tolerance{}, [&](Request& request) { request.relative_floor = wrong; })) << wrong;
  }
  EXPECT_TRUE(isRefusedRequest(Tolerance{}, [](Request& request) { request.amount.replicates = 1; }));
  EXPECT_TRUE(isRefusedRequest(Tolerance{}, [](Request& request) { request.amount.resolution = kMaxResolution + 1; }));
}

TEST(FrontDoor, AMeanOfAllErrorsIsOfAllPolygons) {
  const Goal goal = RootMeanSquare{};
  EXPECT_FALSE(isRefusedRequest(goal, [](Request&) {}));
  EXPECT_TRUE(isRefusedRequest(goal, [](Request& request) { request.by = By::surface; }));
  EXPECT_TRUE(isRefusedRequest(goal, [](Request& request) { request.question.from = {"floor"}; }));
  EXPECT_TRUE(isRefusedRequest(goal, [](Request& request) { request.promise = true; }));
}

TEST(FrontDoor, AGuaranteeSaysWhatHolds) {
  const Scene scene = buildScene(ts::parallelSquares());
  Request request = onHost(EpsilonDelta{.epsilon = 0.1, .delta = 0.1});
  for (const bool pair_lines : {false, true}) {
    request.pair_lines = pair_lines;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.guarantee);
    EXPECT_LE(result.guarantee->bound, 0.1);
    EXPECT_NEAR(result.form_factors.formFactor(0, 1).value, kParallelSquares, 0.1);
    const Interval interval = result.form_factors.interval(0, 1);
    EXPECT_LE(interval.lower, kParallelSquares + 1e-6);
    EXPECT_GE(interval.upper, kParallelSquares - 1e-6);
    // Pairs without an entry have only the bound: here a square with itself.
    EXPECT_EQ(result.form_factors.interval(0, 0).upper, pair_lines ? 0 : result.guarantee->bound);
    EXPECT_EQ(result.plan.guarantee.has_value(), !pair_lines);
    EXPECT_EQ(result.plan.line_guarantee.has_value(), pair_lines);
    if (pair_lines) continue;
    EXPECT_EQ(result.directions, result.replicates * result.plan.guarantee->block_directions);
  }
}

// The closure describes the form factors that are returned.
TEST(FrontDoor, ClosureIsOfTheMatrixDelivered) {
  Ids ids;
  ids.names = {"a", "b", "c"};
  ids.areas = {1, 2, 4};
  ids.surface = {0, 1, 2};
  const FormFactors f(ids, {{0, 1, {0.5, 0.1}}, {1, 2, {1, 0.2}, 0.1}}, {{1.02, 0.01}, {0.97, 0.03}, {1, 0}});
  const Closure closure = measureClosure(f);
  EXPECT_EQ(closure.row, "b");
  EXPECT_NEAR(closure.largest_error, 0.03, 1e-15);
  EXPECT_EQ(closure.standard_error, 0.03);
  EXPECT_NEAR(closure.rms_error, std::sqrt((0.02 * 0.02 + 0.03 * 0.03) / 3), 1e-15);
  const StandardErrors errors = measureStandardErrors(f, 2);  // 0.1, 0.05, 0.1, 0.05
  EXPECT_EQ(errors.count, 4u);
  EXPECT_NEAR(errors.rms, std::sqrt(0.025 / 4), 1e-15);
  EXPECT_EQ(errors.worst.size(), 2u);
  const double squares = 0.1 * 0.1 + 0.05 * 0.05 + std::pow(0.1 / 2, 2) + std::pow(0.1 / 4, 2);  // of errors in sums
  EXPECT_NEAR(errors.rms_with_zeros, std::sqrt(squares) / 3, 1e-15);
  const Result result = computeFormFactors(loadScene(VIEWPEEL_SCENES "/office.obj"), onHost(Tolerance{2e-2}));
  EXPECT_EQ(result.closure.largest_error, measureClosure(result.form_factors).largest_error);
  EXPECT_GT(result.closure.largest_error, 0);
}

// The caller hands in the exact engine, which computes 2 x 400 directions without a lattice. Without it, this engine is
// refused.
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

// A run stops after four replicates and goes on from its checkpoint to eight. It follows the plan of the first run,
// although the second request has no amounts.
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

// A run stops when the observer asks. Before the first replicate it has no result, later the result of the replicates
// so far.
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

// A closed scene has balanced form factors. An open one has a refusal beside its measured form factors.
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

// --- pair lines -----------------------------------------------------------------------------------------------------

Result byPairLines(const Scene& scene, Goal goal, uint64_t seed) {
  Request request = onHost(goal);
  request.pair_lines = true;
  request.seed = seed;
  return computeFormFactors(scene, request);
}

// The truth is the integral past one blocker, a plate between two squares. No form factor is off by more than the
// tolerance, which is 4.25 standard errors. At least 40 of the 80 errors are above a hundredth of it, so the tolerance
// is not far too wide.
TEST(PairLineRuns, ErrorsAreBelowTheTolerance) {
  namespace rt = reference::test;
  const rt::Corners lower = rt::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    upper = rt::rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}),
                    plate = rt::rectangle({0.3, 0.2, 0.4}, {0.5, 0, 0.1}, {0, 0.4, 0});
  InputScene input{"plate", {}, {}};
  ts::addFace(input, "lower", lower);
  ts::addFace(input, "upper", upper);
  ts::addFace(input, "plate", plate);
  const Scene scene = buildScene(input);
  const double truth = reference::formFactorPastBlocker(lower, upper, plate).value,
               to_back = reference::formFactor(lower, rt::flipped(plate));
  int larger = 0;
  for (const double tolerance : {1e-2, 1e-3})
    for (uint64_t seed = 1; seed <= 40; ++seed) {
      const Result result = byPairLines(scene, Tolerance{tolerance}, seed);
      const double error = std::abs(result.form_factors.formFactor(0, 1).value - truth);
      EXPECT_LE(error, tolerance) << seed;
      larger += error > 0.01 * tolerance;
      // From the lower square nothing hides the back of the plate, so leak is exact, and rows add up.
      EXPECT_NEAR(result.form_factors.formFactor(0, kLeak).value, to_back, 1e-6);
      EXPECT_NEAR(result.form_factors.rowSums()[0].value, 1, 1e-12);
      EXPECT_NEAR(result.form_factors.formFactor(0, kEnvironment).value, 1 - truth - to_back, tolerance);
    }
  EXPECT_GE(larger, 40);
}

// 36 towers of 4 x 4 stand 0.05 apart, so that polygons between them see little of the sky, and few directions find it.
// A row without an environment must be known well enough to say that it sees none: three standard errors of its sum,
// which would show one, are within the tolerance. Without lines for these rows 48 of them have a wider sum.
TEST(PairLineRuns, RowsWithoutAnEnvironmentAreKnown) {
  constexpr double kTolerance = 3e-3, kWidth = 4, kStep = 4.05;
  namespace rt = reference::test;
  InputScene input{"towers", {}, {}};
  const auto addPanels = [&](glm::dvec3 corner, glm::dvec3 along, glm::dvec3 up, int panels) {
    for (int k = 0; k < panels; ++k)
      ts::addFace(input, std::to_string(input.faces.size()),
                  rt::rectangle(corner + up * (double(k) / panels), along, up / double(panels)));
  };
  SceneRandom random(1);
  for (int tower = 0; tower < 36; ++tower) {
    const glm::dvec3 x{kWidth, 0, 0}, y{0, kWidth, 0}, high{0, 0, random.uniform(8, 30)},
        corner{kStep * (tower % 6), kStep * (tower / 6), 0};
    const double street = kStep - kWidth;
    addPanels(corner, x, high, 4);
    addPanels(corner + x, y, high, 4);
    addPanels(corner + x + y, -x, high, 4);
    addPanels(corner + y, -y, high, 4);
    addPanels(corner + high, x, y, 1);
    addPanels(corner + x, {street, 0, 0}, y, 2);
    addPanels(corner + y, x, {0, street, 0}, 2);
    addPanels(corner + x + y, {street, 0, 0}, {0, street, 0}, 1);
  }
  const Result result = byPairLines(buildScene(input), Tolerance{kTolerance}, 1);
  const FormFactors& found = result.form_factors;
  int without = 0;
  for (uint32_t i = 0; i < found.ids().count(); ++i) {
    const Measured row = found.rowSums()[i];
    if (found.formFactor(i, kEnvironment).value > 0) continue;
    ++without;
    EXPECT_TRUE(row.value >= 1 || 3 * row.standard_error <= kTolerance)
        << found.ids().names[i] << ": " << row.value << " +- " << row.standard_error;
  }
  EXPECT_GT(without, 20);
}

// Pair lines alone make the rows of closed rooms sum to 1; no step forces them. In 20 rooms with boxes one row of
// 16,000 would be beyond 4 of its standard errors, if errors were normal. At most one of 200 may be.
TEST(PairLineRuns, RowsOfClosedScenesAddUp) {
  int rows = 0, beyond = 0;
  double worst = 0;
  for (const stress::Kind kind : {stress::Kind::boxes, stress::Kind::turned})
    for (uint64_t seed = 0; seed < 10; ++seed) {
      const Result result = byPairLines(buildScene(stress::makeScene(kind, seed)), Tolerance{5e-3}, seed + 1);
      for (const Measured& row : result.form_factors.rowSums()) {
        ++rows;
        beyond += std::abs(row.value - 1) > 4 * row.standard_error + 1e-6;
        worst = std::max(worst, std::abs(row.value - 1));
      }
    }
  EXPECT_GT(rows, 200);
  EXPECT_LE(beyond, rows / 200);
  EXPECT_GT(worst, 1e-5);  // sums are not forced to 1
}

// Pair lines and common directions give the same matrix within their errors. They share neither lines nor rules of
// visibility.
TEST(PairLineRuns, AgreeWithCommonDirections) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  for (const bool two_sided : {false, true})
    for (const By by : {By::polygon, By::surface}) {
      SCOPED_TRACE(testing::Message() << (two_sided ? "two-sided, " : "") << (by == By::surface ? "surfaces" : ""));
      Request request = onHost(Tolerance{2e-3});
      request.by = by;
      request.two_sided = two_sided;
      request.pair_lines = true;
      const Result lines = computeFormFactors(scene, request);
      request.pair_lines = false;
      const Result directions = computeFormFactors(scene, request);
      double squares = 0;
      int count = 0, beyond = 0;
      for (const auto& entry : directions.form_factors.entries()) {
        const Measured a = entry.exchange_area, b = lines.form_factors.exchangeArea(entry.i, entry.j);
        const double error = std::hypot(a.standard_error, b.standard_error);
        if (!(b.standard_error > 1e-5 * b.value)) continue;
        const double z = (a.value - b.value) / error;
        squares += z * z, ++count, beyond += std::abs(z) > 5;
      }
      ASSERT_GT(count, 20);
      EXPECT_LT(std::sqrt(squares / count), 1.3);
      EXPECT_GT(std::sqrt(squares / count), 0.2);
      EXPECT_LE(beyond, count / 500);
    }
}

TEST(PairLineRuns, ThreadsDoNotMatterAndSeedsDo) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  Request request = onHost(Tolerance{1e-2});
  request.threads = 1;
  const Result one = computeFormFactors(scene, request);
  EXPECT_TRUE(one.plan.pair_lines);
  request.threads = 3;
  expectSameBits(one.form_factors, computeFormFactors(scene, request).form_factors);
  request.seed = 2;
  const Result other = computeFormFactors(scene, request);
  bool differs = other.form_factors.entries().size() != one.form_factors.entries().size();
  for (size_t k = 0; k < other.form_factors.entries().size() && !differs; ++k)
    differs = other.form_factors.entries()[k].exchange_area.value != one.form_factors.entries()[k].exchange_area.value;
  EXPECT_TRUE(differs);
}

TEST(PairLineRuns, GoOnFromACheckpoint) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  const Request request = onHost(Tolerance{2e-3});
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "pair_lines.h5";
  const Result whole = computeFormFactors(scene, request);
  {
    FormFactorRun first(scene, request);
    for (int k = 0; k < 5; ++k) first.step();
    first.writeCheckpoint(file);
  }
  FormFactorRun second(scene, request);
  second.resumeFrom(file);
  while (!second.isDone()) second.step();
  expectSameBits(whole.form_factors, second.result().form_factors);
  std::filesystem::remove(file);
}

// Only the requested rows get lines. Their values agree with the whole matrix's within 6 of its standard errors.
TEST(PairLineRuns, AnswerQuestions) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  Request request = onHost(Tolerance{5e-3});
  const Result all = computeFormFactors(scene, request);
  request.question.from = {"road"};
  const Result rows = computeFormFactors(scene, request);
  EXPECT_LT(rows.lines, all.lines / 2);
  int compared = 0;
  for (const auto& entry : rows.form_factors.entries()) {
    if (!rows.form_factors.ids().isRequested(entry.i) || entry.j >= kEnvironment) continue;
    const Measured whole = all.form_factors.exchangeArea(entry.i, entry.j);
    EXPECT_NEAR(entry.exchange_area.value, whole.value, 6 * whole.standard_error + 1e-12);
    ++compared;
  }
  EXPECT_GT(compared, 100);
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
  EXPECT_EQ(refusal({.goal = Seconds{}, .pair_lines = true}), "");
  EXPECT_NE(refusal({.goal = Seconds{}, .amount = {.is_exact = true}, .pair_lines = true}).find("parts a tolerance"),
            std::string::npos);
  EXPECT_NE(refusal({.amount = {.directions = 64}, .pair_lines = true}).find("--directions"), std::string::npos);
  EXPECT_NE(refusal({.unoccluded = true, .pair_lines = true}).find("leave out --unoccluded"), std::string::npos);
}

}  // namespace
}  // namespace viewpeel
