// A tolerance is promised where a promise costs little more than an estimate. These tests check when there is a
// promise, that it holds, and what the run reports about it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>

#include "estimator/promise_cost.h"
#include "pair_lines/pair_lines.h"
#include "scenes/named_scenes.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
namespace rt = reference::test;

Request toleranceOf(double tolerance) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.engine = EngineKind::host;
  return request;
}

Scene street() { return loadScene(VIEWPEEL_SCENES "/street.obj"); }

// Expects that every form factor, and the environment, lies within an interval of at most the promised width.
void expectKept(const Result& result, double tolerance) {
  ASSERT_TRUE(result.guarantee);
  EXPECT_LE(result.guarantee->delta, 0.01);
  EXPECT_EQ(result.plan.no_promise, "");
  ASSERT_TRUE(result.form_factors.hasIntervals());
  const FormFactors& f = result.form_factors;
  for (const FormFactors::Entry& entry : f.entries())
    for (const auto& [from, to] : {std::pair(entry.i, entry.j), std::pair(entry.j, entry.i)}) {
      // This is the form factor from the smaller of the two ids; the other one is smaller by the ratio of areas.
      if (from >= kEnvironment || (to < kEnvironment && f.ids().areas[from] > f.ids().areas[to])) continue;
      const Interval interval = f.interval(from, to);
      const double value = f.formFactor(from, to).value;
      EXPECT_LE(interval.upper - value, tolerance + 1e-12) << from << " to " << to;
      EXPECT_LE(value - interval.lower, tolerance + 1e-12) << from << " to " << to;
    }
}

TEST(Promise, IntervalsAreWithinTheTolerance) {
  for (const By by : {By::polygon, By::surface})
    for (const bool two_sided : {false, true}) {
      SCOPED_TRACE(testing::Message() << (by == By::surface ? "surfaces" : "polygons")
                                      << (two_sided ? " on both sides" : ""));
      Request request = toleranceOf(1e-2);
      request.by = by;
      request.two_sided = two_sided;
      request.promise = true;
      expectKept(computeFormFactors(street(), request), 1e-2);
    }
  // A closed scene has no environment to promise.
  const Result office = computeFormFactors(loadScene(VIEWPEEL_SCENES "/office.obj"), toleranceOf(1e-2));
  expectKept(office, 1e-2);
  EXPECT_EQ(office.environment_share, 0);
}

// The office at this epsilon draws lines in strata beside uniform lines. The plan's largest number holds for both.
TEST(Promise, DrawsAtMostTheLinesThatThePlanStates) {
  Request request = toleranceOf(1e-3);
  request.goal = EpsilonDelta{2e-3};
  const Result office = computeFormFactors(loadScene(VIEWPEEL_SCENES "/office.obj"), request);
  expectKept(office, 2e-3);
  ASSERT_TRUE(office.plan.line_guarantee);
  EXPECT_GT(office.lines, 0u);
  EXPECT_LE(double(office.lines), office.plan.line_guarantee->most_lines);
}

// Each of 20 seeds may fail with probability 0.01, so more than 4 failures occur once in 40,000 runs of this test. The
// truth is an estimate with a twentieth of the tolerance.
TEST(Promise, HoldsTheTruth) {
  const Scene scene = street();
  Request fine = toleranceOf(5e-4);
  fine.promise = false;
  const FormFactors truth = computeFormFactors(scene, fine).form_factors;
  int failures = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Request request = toleranceOf(1e-2);
    request.seed = seed;
    const Result result = computeFormFactors(scene, request);
    ASSERT_TRUE(result.guarantee);
    bool fails = false;
    for (const FormFactors::Entry& entry : truth.entries()) {
      const Interval interval = result.form_factors.interval(entry.i, entry.j);
      const Measured expected = truth.formFactor(entry.i, entry.j);
      fails |= expected.value < interval.lower - 6 * expected.standard_error;
      fails |= expected.value > interval.upper + 6 * expected.standard_error;
    }
    failures += fails;
  }
  EXPECT_LE(failures, 4);
}

// Returns a room with the plan of an L: eight polygons, of which two are not convex.
Scene lRoom() {
  const std::vector<glm::dvec2> plan{{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}};
  InputScene input{"l", {}, {}};
  std::vector<glm::dvec3> floor, ceiling;
  for (size_t k = 0; k < plan.size(); ++k) {
    const glm::dvec2 from = plan[k], to = plan[(k + 1) % plan.size()];
    floor.emplace_back(from, 0);
    ceiling.insert(ceiling.begin(), {from, 2.5});
    ts::addFace(input, "wall", {{to, 0}, {from, 0}, {from, 2.5}, {to, 2.5}});
  }
  ts::addFace(input, "floor", floor);
  ts::addFace(input, "ceiling", ceiling);
  return buildScene(input);
}

// A promise takes many more lines than an estimate here, but both are a small part of the run.
TEST(Promise, IsTheDefaultInASmallRoom) {
  const Scene scene = lRoom();
  ASSERT_EQ(scene.faces.size(), 8u);
  const Result result = computeFormFactors(scene, toleranceOf(1e-3));
  expectKept(result, 1e-3);
  EXPECT_GT(result.lines, 0u);
  // The same request of a dearer scene is an estimate, and its plan states the ratio of both costs.
  const Scene office = loadScene(VIEWPEEL_SCENES "/office.obj");
  Request request = toleranceOf(1e-3);
  FormFactorRun by_default(office, request);
  const PlanSummary& estimate = by_default.makePlan();
  EXPECT_FALSE(estimate.line_guarantee);
  request.promise = true;
  FormFactorRun promised(office, request);
  const LineGuaranteeFigures figures = promised.makePlan().line_guarantee.value();
  EXPECT_GT(figures.cost, 2 * figures.estimate_cost);
  EXPECT_NE(estimate.no_promise.find(
                fmt::format("a promise would cost {:.2g} times as much", figures.cost / figures.estimate_cost)),
            std::string::npos)
      << estimate.no_promise;
}

// Costs are of whole runs: work that both have brings them nearer together.
TEST(Promise, CostsAreOfWholeRuns) {
  const std::array exchanges{0.3};
  const EntryLines entry{.exchanges = exchanges,
                         .smaller_area = 1,
                         .is_pair = true,
                         .share = 0.5,
                         .lines = 1e6,
                         .candidates = 2e6,
                         .strata = 0,
                         .blockers = 3};
  SharedWork shared{.faces = 8, .directions = 320, .pairs = 30, .finding = {.shafts = 50, .tests = 200}};
  PromiseCost alone(1e-3, shared);
  alone.add(entry, 100);
  EXPECT_FALSE(isWorthPromise(alone.ofPromise(), alone.ofEstimate()));
  shared.finding.tests = 10'000'000'000;
  PromiseCost with_search(1e-3, shared);
  with_search.add(entry, 100);
  EXPECT_NEAR(with_search.ofPromise() - alone.ofPromise(), with_search.ofEstimate() - alone.ofEstimate(), 1e-9);
  EXPECT_TRUE(isWorthPromise(with_search.ofPromise(), with_search.ofEstimate()));
  // Either rule is enough for a promise; neither holds just beyond both limits.
  EXPECT_TRUE(isWorthPromise(0.49, 0.01));
  EXPECT_TRUE(isWorthPromise(1.9, 1.0));
  EXPECT_FALSE(isWorthPromise(0.51, 0.25));
}

// Numbers of pairs and lines alone decide about a promise, so every machine decides alike.
TEST(Promise, IsMadeWhereItCostsLittle) {
  const Scene scene = street();
  Request request = toleranceOf(1e-2);
  request.threads = 1;
  FormFactorRun one(scene, request);
  request.threads = 3;
  FormFactorRun three(scene, request);
  ASSERT_TRUE(one.makePlan().line_guarantee);
  EXPECT_EQ(one.plan().line_guarantee->cost, three.makePlan().line_guarantee->cost);
  EXPECT_EQ(one.plan().line_guarantee->estimate_cost, three.plan().line_guarantee->estimate_cost);
  EXPECT_EQ(std::get<EpsilonDelta>(one.request().goal).epsilon, 1e-2);
  // At a finer tolerance a promise takes lines as the error's inverse square; an estimate's lines grow more slowly.
  const Result fine = computeFormFactors(scene, toleranceOf(3e-4));
  EXPECT_FALSE(fine.guarantee);
  EXPECT_FALSE(fine.form_factors.hasIntervals());
  EXPECT_NE(fine.plan.no_promise.find("times as much"), std::string::npos) << fine.plan.no_promise;
  // In between it costs more than twice an estimate, but less than half a second.
  FormFactorRun between(scene, toleranceOf(1e-3));
  const LineGuaranteeFigures figures = between.makePlan().line_guarantee.value();
  EXPECT_GT(figures.cost, 2 * figures.estimate_cost);
  EXPECT_LE(figures.cost, 0.5);
}

TEST(Promise, IsNotMadeWhereTheRequestIsAboutEstimates) {
  const Scene scene = street();
  const auto expectEstimate = [&](Request request, const std::string& why) {
    const Result result = computeFormFactors(scene, request);
    EXPECT_FALSE(result.guarantee) << why;
    EXPECT_NE(result.plan.no_promise.find(why), std::string::npos) << result.plan.no_promise;
    request.promise = true;
    if (why.starts_with("--") && why != "--promise off") {
      EXPECT_THROW(checkRequest(request), Error) << why;
    }
  };
  Request request = toleranceOf(1e-2);
  request.promise = false;
  expectEstimate(request, "--promise off");
  request = toleranceOf(1e-2);
  request.amount.replicates = 9;
  expectEstimate(request, "--replicates");
  request = toleranceOf(1e-2);
  request.time_limit_s = 100;
  expectEstimate(request, "--seconds");
  request = toleranceOf(1e-2);
  request.sampler = Sampler::iid;
  expectEstimate(request, "--sampler");
  request = toleranceOf(1e-2);
  request.pair_lines = false;
  expectEstimate(request, "--pair-lines");
  request = toleranceOf(1e-2);
  request.goal = Tolerance{1e-2, 0.1};
  expectEstimate(request, "--relative");
  request.goal = FixedAmount{.directions = 16, .replicates = 2};
  expectEstimate(request, "--directions");
  request.goal = EpsilonDelta{};
  request.promise = false;
  EXPECT_THROW(checkRequest(request), Error);
}

// A run to a tolerance says why it has no pair lines, with a promise or without.
TEST(NoPairLines, AreExplained) {
  const Scene scene = street();
  const auto expectReason = [&](Request request, const std::string& why) {
    for (const std::optional<bool> promise : {std::optional<bool>(), std::optional(false)}) {
      request.promise = promise;
      FormFactorRun run(scene, request);
      run.makePlan();
      EXPECT_EQ(run.plan().no_pair_lines, why);
      EXPECT_FALSE(run.plan().pair_lines || run.plan().line_guarantee) << why;
    }
  };
  const std::pair<const char*, void (*)(Request&)> options[] = {
      {"--pair-lines off", [](Request& request) { request.pair_lines = false; }},
      {"--sampling", [](Request& request) { request.sampling = Sampling::lattice; }},
      {"--sampler", [](Request& request) { request.sampler = Sampler::iid; }},
      {"--unoccluded", [](Request& request) { request.unoccluded = false; }},
      {"--resolution", [](Request& request) { request.amount.resolution = 128; }}};
  for (const auto& [option, set] : options) {
    Request request = toleranceOf(1e-2);
    set(request);
    expectReason(request, std::string(option) + " asks for common directions");
  }
  Request request = toleranceOf(1e-2);
  request.goal = FixedAmount{.directions = 16, .replicates = 2};
  expectReason(request, "");  // such a run has no goal that lines could serve
  for (const double tolerance : {0.2, 0.05, 1e-2, 1e-3}) {
    FormFactorRun run(scene, toleranceOf(tolerance));
    run.makePlan();
    EXPECT_TRUE(run.plan().pair_lines || run.plan().line_guarantee);
    EXPECT_EQ(run.plan().no_pair_lines, "");
  }
}

// The back of a plate receives radiation. This leak has no interval, so nothing can be promised.
TEST(Promise, IsNotMadeWhereLinesEndOnBacks) {
  InputScene input{"leak", {}, {}};
  ts::addFace(input, "lower", rt::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "upper", rt::rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}));
  ts::addFace(input, "plate", rt::rectangle({0.3, 0.2, 0.4}, {0.5, 0, 0.1}, {0, 0.4, 0}));
  const Scene scene = buildScene(input);
  Request request = toleranceOf(1e-2);
  const Result result = computeFormFactors(scene, request);
  EXPECT_FALSE(result.guarantee);
  EXPECT_NE(result.plan.no_promise.find("ends on backs"), std::string::npos) << result.plan.no_promise;
  request.promise = true;
  EXPECT_THROW(computeFormFactors(scene, request), Error);
}

// Returns a ground, and above it a panel that common directions hardly meet. The back of a plate above the panel takes
// this share of what the panel emits.
Scene panelUnderPlate(double share) {
  constexpr double kPanel = 1e-3, kAbove = 1;
  // A plate that is small beside its height has the form factor s = area / (pi height^2), and less by about pi s^2 / 3.
  const double side = std::sqrt(share * std::numbers::pi) * kAbove;
  InputScene input{"panel under a plate", {}, {}};
  ts::addFace(input, "ground", ts::parallelogram({-50, 1, 0}, {100, 0, 0}, {0, 100, 0}));
  ts::addFace(input, "panel", ts::parallelogram({0, 0, 0}, {kPanel, 0, 0}, {0, kPanel, 0}));
  ts::addFace(input, "plate", ts::parallelogram({-side / 2, -side / 2, kAbove}, {side, 0, 0}, {0, side, 0}));
  return buildScene(input);
}

// Of the panel's 768 rays some 4 end on the back of the plate, so that these runs find the leak. With 64 rays eight of
// the ten promised an environment of 1.
TEST(Promise, IsNotMadeWhereATinyPolygonLeaks) {
  const Scene scene = panelUnderPlate(5e-3);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Request request = toleranceOf(1e-2);
    request.seed = seed;
    const Result result = computeFormFactors(scene, request);
    EXPECT_FALSE(result.guarantee) << seed;
    EXPECT_NE(result.plan.no_promise.find("ends on backs"), std::string::npos) << result.plan.no_promise;
  }
}

// The back of the plate is exposed, so that lines of the panel may end on it. Its leak has an interval, and is no part
// of the environment's interval, however small it is.
TEST(Promise, SmallLeaksToExposedBacksHaveIntervals) {
  constexpr uint32_t kOfPanel = 1;
  for (const double share : {2e-2, 2e-4}) {
    Request request = toleranceOf(1e-2);
    request.goal = EpsilonDelta{.epsilon = 1e-2};
    const FormFactors found = computeFormFactors(panelUnderPlate(share), request).form_factors;
    const Interval leak = found.interval(kOfPanel, kLeak), environment = found.interval(kOfPanel, kEnvironment);
    const double small_angle = 2 * share;  // see panelUnderPlate()
    EXPECT_NEAR(leak.upper, share, small_angle * share);
    EXPECT_NEAR(environment.upper, 1 - share, small_angle * share);
  }
}

// Where rounding is larger than the tolerance there is no promise, and the estimate alone refuses or accepts it.
TEST(Promise, IsNotMadeBelowRounding) {
  const Scene scene = buildScene(ts::cubeInCube(0.5));
  FormFactorRun run(scene, toleranceOf(1e-6));
  const PlanSummary& plan = run.makePlan();
  EXPECT_FALSE(plan.line_guarantee);
  EXPECT_NE(plan.no_promise.find("rounding"), std::string::npos) << plan.no_promise;
  // Pairs that nothing blocks are exact, so that even this tolerance is promised.
  const Result exact = computeFormFactors(buildScene(ts::insideOfCube()), toleranceOf(1e-9));
  ASSERT_TRUE(exact.guarantee);
  EXPECT_LE(exact.guarantee->bound, 1e-12);
}

// Planted fault: after the plan the first part of the lines fails as lines do that rounding leaves open. A promise that
// was made by default goes on as an estimate and says why. One that the request insists on ends with the error.
TEST(Promise, GoesOnAsAnEstimateWhereItCannotBeKept) {
  const Scene scene = street();
  Request request = toleranceOf(1e-2);
  bool is_planned = false;
  int calls = 0;
  Observer observer;
  observer.should_stop = [&] {
    if (is_planned && calls++ == 0) throw Error(ErrorCode::limit, "rounding leaves planted lines open");
    return false;
  };
  FormFactorRun run(scene, request, observer);
  ASSERT_TRUE(run.makePlan().line_guarantee);
  is_planned = true;
  while (!run.isDone()) run.step();
  const Result result = run.result();
  EXPECT_GT(calls, 1);
  EXPECT_FALSE(result.guarantee);
  EXPECT_FALSE(result.form_factors.hasIntervals());
  EXPECT_TRUE(result.goal_reached);
  EXPECT_EQ(result.plan.no_promise, "rounding leaves planted lines open");
  // It is the estimate that the same request without a promise gives, bit for bit.
  request.promise = false;
  const FormFactors expected = computeFormFactors(scene, request).form_factors;
  ASSERT_EQ(result.form_factors.entries().size(), expected.entries().size());
  for (size_t k = 0; k < expected.entries().size(); ++k)
    EXPECT_EQ(result.form_factors.entries()[k].exchange_area.value, expected.entries()[k].exchange_area.value);
  request.promise = true;
  is_planned = false, calls = 0;
  FormFactorRun insisting(scene, request, observer);
  insisting.makePlan();
  is_planned = true;
  EXPECT_THROW(insisting.step(), Error);
}

// Of what two surfaces exchange, all but 1e-17 is clear. The rest, past a strip some nanometres wide, is blockable. It
// is less than rounding of the sum, and the lines that it needs are finite all the same.
TEST(Promise, PartsBelowRoundingNeedFewLines) {
  constexpr double kStrip = 5e-9;
  InputScene input;
  ts::addFace(input, "low", ts::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const ts::Corners fronts[] = {ts::parallelogram({0, 0, 0.4}, {0, 1, 0}, {0.6, 0, 0}),
                                ts::parallelogram({1 - kStrip, 0, 0.5}, {0, 1, 0}, {0, 0, 1}),
                                ts::parallelogram({0.9, 0.3, 0.3}, {0.6, 0, 0}, {0, 0.3, 0})};
  ts::addFace(input, "high", fronts[0]);
  ts::addFace(input, "high", fronts[1]);
  ts::addFace(input, "plate", fronts[2]);
  for (const ts::Corners& front : fronts) ts::addFace(input, "back", {front.rbegin(), front.rend()});
  const Scene scene = buildScene(input);
  PairLines lines(scene, makeIds(scene, By::polygon, false), {}, 1, 1);
  const std::vector<LinePair> pairs = lines.find();
  ASSERT_TRUE(std::ranges::any_of(pairs, [](const LinePair& pair) {
    return pair.i == 0 && pair.j == 2 && pair.exchange > 0 && pair.exchange < 1e-17 && pair.clear < pair.exchange;
  })) << "the strip's pair may be blocked";
  Request request = toleranceOf(1e-2);
  request.by = By::surface, request.promise = true;
  const Result result = computeFormFactors(scene, request);
  expectKept(result, 1e-2);
  EXPECT_LT(result.plan.line_guarantee->most_lines, 1e7);
}

// A prediction draws lines and directions of its own, so that the run after it has the bits of a run without one. It
// is above 0 for each kind of run: a promise, an estimate by lines, and common directions.
TEST(Predictions, LeaveTheRunAsItIs) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  std::vector<Request> requests{toleranceOf(1e-2), toleranceOf(1e-3), toleranceOf(1e-2)};
  requests[1].promise = false;
  requests[2].goal = FixedAmount{.directions = 16};
  for (const Request& request : requests) {
    FormFactorRun predicted(scene, request), plain(scene, request);
    EXPECT_GT(predicted.measureSeconds(), 0);
    EXPECT_GT(predicted.plan().plan_seconds, 0);
    std::vector<FormFactors> found;
    for (FormFactorRun* run : {&predicted, &plain}) {
      while (!run->isDone()) run->step();
      found.push_back(run->resultSoFar().form_factors);
    }
    ASSERT_EQ(found[0].entries().size(), found[1].entries().size());
    for (size_t k = 0; k < found[0].entries().size(); ++k) {
      const FormFactors::Entry &a = found[0].entries()[k], &b = found[1].entries()[k];
      ASSERT_EQ(std::pair(a.i, a.j), std::pair(b.i, b.j));
      ASSERT_EQ(a.exchange_area.value, b.exchange_area.value);
      ASSERT_EQ(a.exchange_area.standard_error, b.exchange_area.standard_error);
    }
  }
}

}  // namespace
}  // namespace viewpeel
