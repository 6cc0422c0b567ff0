// These scenes have so many polygons that not all pairs get an unoccluded form factor before the run.
#include <cmath>
#include <map>
#include <optional>

#include <gtest/gtest.h>

#include "engines/host_engine.h"
#include "estimator/find_prior.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// ManyPolygons has more pairs than get an unoccluded form factor before the run. Nothing is blocked, so that the
// visibility of neighbours is right for a pair that no line met.
class ManyPolygons {
 public:
  static constexpr uint32_t kCuts = 40;

  ManyPolygons() {
    options.prior = &found.prior;
    options.exchanges = &exchanges;
    options.on_sums = [this](const RunSums& sums, bool last) {
      if (!last) after.push_back(sums);
    };
  }

  Estimate estimate(const EstimateOptions& run) { return estimateFormFactors(*engine, scene, ids, run); }

  // Returns the unoccluded exchange area of a pair in double precision.
  double exchangeOf(uint32_t i, uint32_t j) {
    PairPrior alone{i, j};
    exchanges.compute(std::span(&alone, 1));
    return alone.exchange;
  }

  const Scene scene = [] {
    InputScene input = ts::squaresInParts(kCuts, 1.0 / kCuts, 1);
    // Many lines meet the wall and each part.
    ts::addFace(input, "wall", ts::parallelogram({-0.5, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    return buildScene(input);
  }();
  const Ids ids = makeIds(scene, By::polygon, false);
  const std::unique_ptr<Engine> engine = makeHostEngine(scene, ids, {.resolution = 64, .count_blocked = true});
  EstimateOptions options{.directions = 128, .replicates = 4};
  FaceExchanges exchanges{nullptr, scene, ids};
  const FoundPrior found =
      findPrior(*engine, exchanges, scene, ids, groupAsOne(scene, 64), options, {choosePriorPilot(options).directions});
  std::vector<RunSums> after;  // sums after each replicate
};

// Every pair of many polygons gets its unoccluded form factor in the end. Pairs with many lines have it in double
// precision, whether pilots met them or not.
TEST(FindPrior, EveryPairOfManyPolygonsGetsItsUnoccludedFormFactor) {
  ManyPolygons run;
  constexpr size_t kCuts = ManyPolygons::kCuts;
  ASSERT_GT(pairCount(run.ids.count()), kMostPriorPairs);
  EXPECT_FALSE(run.found.prior.has_all_pairs);
  const Estimate whole = run.estimate(run.options);
  std::map<std::pair<uint32_t, uint32_t>, uint64_t> lines;
  for (const VisibilitySums::PairSum& pair : run.after.back().prior_sums->byFace().pairs())
    lines[{pair.i, pair.j}] = pair.facing + pair.blocked;
  const ExchangeRow row = run.exchanges.rows();
  std::vector<BoundedExchange> later;
  uint32_t row_of = UINT32_MAX;
  size_t learnt = 0, counted = 0, guessed = 0, unmet = 0, all = 0;
  for (const FormFactors::Entry& entry : whole.form_factors.entries()) {
    if (entry.j >= kEnvironment) continue;
    ++all;
    const bool had_prior = std::ranges::binary_search(run.found.prior.pairs, std::pair(entry.i, entry.j), {},
                                                      [](const PairPrior& pair) { return std::pair(pair.i, pair.j); });
    const uint64_t line_count = lines[{entry.i, entry.j}];
    unmet += line_count == 0;
    size_t& kind = line_count >= kLinesToLearn ? learnt : line_count ? counted : guessed;
    if (had_prior || kind++ % 100) continue;
    const double exchange = run.exchangeOf(entry.i, entry.j);
    if (line_count >= kLinesToLearn) {
      EXPECT_EQ(entry.exchange_area.value, exchange);
    }
    if (row_of != entry.i) {
      row_of = entry.i;
      later.assign(run.ids.count() - row_of - 1, {});
      row(row_of, later);
    }
    const BoundedExchange& bounded = later[entry.j - entry.i - 1];
    EXPECT_NEAR(entry.exchange_area.value, exchange, bounded.error + kUnoccludedRelativeError * exchange);
    EXPECT_LT(bounded.error, 0.01 * exchange);  // parts of edge 1/40 at a distance of 1 or more are far pairs
  }
  EXPECT_EQ(all, kCuts * kCuts * (kCuts * kCuts + 2));
  EXPECT_EQ(whole.unmet_pairs, unmet);
  EXPECT_GT(learnt, 0u);  // few, for pilots met nearly all such pairs
  for (const size_t count : {counted, guessed}) EXPECT_GT(count, 500u);
}

// A run of many polygons that is resumed from sums, or merged from parts, has the bits of the whole run.
TEST(FindPrior, PartsOfARunOfManyPolygonsComeToTheSameBits) {
  ManyPolygons run;
  const Estimate whole = run.estimate(run.options);
  const auto isTheSame = [&](const FormFactors& other) {
    const auto& a = whole.form_factors.entries();
    const auto& b = other.entries();
    return std::ranges::equal(a, b, [](const FormFactors::Entry& x, const FormFactors::Entry& y) {
      return x.i == y.i && x.j == y.j && x.exchange_area.value == y.exchange_area.value &&
             x.exchange_area.standard_error == y.exchange_area.standard_error;
    });
  };
  ASSERT_EQ(run.after.size(), 4u);
  const RunSums begun = run.after[1];
  run.options.resumed = &begun;
  EXPECT_TRUE(isTheSame(run.estimate(run.options).form_factors));
  EstimateOptions second = run.options;
  second.resumed = nullptr;
  second.first_replicate = 2;
  second.replicates = 2;
  run.after.clear();
  run.estimate(second);
  const ExchangeRow row = run.exchanges.rows();
  for (const bool in_order : {true, false}) {
    RunSums sum = in_order ? begun : run.after[1];
    sum.add(in_order ? run.after[1] : begun);
    run.exchanges.learn(sum);
    EXPECT_TRUE(isTheSame(keepSeen(sum.formFactors(row)))) << in_order;
  }
}

// A run ends with the first replicate after which all standard errors reach the goal. These errors include the bound of
// unoccluded form factors in single precision, and the errors of pairs that no line met.
TEST(FindPrior, GoalsAreReachedByEveryPairOfManyPolygons) {
  constexpr uint32_t kCuts = 55;
  InputScene input{"a floor in 3025 parts below a lamp and a screen", {}, {}};
  for (uint32_t row = 0; row < kCuts; ++row)
    for (uint32_t column = 0; column < kCuts; ++column)
      ts::addFace(input, "floor", ts::parallelogram({double(column), double(row), 0}, {1, 0, 0}, {0, 1, 0}));
  ts::addFace(input, "lamp", ts::parallelogram({20, 20, 30}, {0, 6, 0}, {6, 0, 0}));
  ts::addFace(input, "screen", ts::parallelogram({24, 16, 15}, {9, 0, 0}, {0, 9, 0}));
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  ASSERT_GT(pairCount(ids.count()), kMostPriorPairs);
  const auto engine = makeHostEngine(scene, ids, {.resolution = 64, .count_blocked = true});
  EstimateOptions options{.directions = 32, .replicates = 3};
  FaceExchanges exchanges(nullptr, scene, ids);
  const FoundPrior found =
      findPrior(*engine, exchanges, scene, ids, groupAsOne(scene, 64), options, {choosePriorPilot(options).directions});
  options.prior = &found.prior;
  options.exchanges = &exchanges;
  const double first = estimateFormFactors(*engine, scene, ids, options).largest_standard_error;
  for (const double visibility : {0.9, 0.7}) {
    options.tolerance = visibility * first;
    std::vector<double> largest;
    options.on_sums = [&](const RunSums& sums, bool last) {
      if (!last) largest.push_back(makeEstimate(sums, options.relative_floor, exchanges.rows()).largest_standard_error);
    };
    const Estimate reached = estimateFormFactors(*engine, scene, ids, options);
    ASSERT_EQ(reached.replicates, largest.size());
    EXPECT_GT(reached.replicates, 3u);
    EXPECT_EQ(reached.largest_standard_error, largest.back());
    for (size_t r = 2; r < largest.size(); ++r)
      EXPECT_EQ(largest[r] <= *options.tolerance, r + 1 == largest.size()) << r;
  }
}

}  // namespace
}  // namespace viewpeel
