// These tests compare bounds of guarantees with bounds computed by hand. They check that no direction exceeds its
// range, and count how often a guarantee fails.
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "engines/size_groups.h"
#include <viewpeel/error.h>
#include "estimator/guarantee.h"
#include "reference/exact/exact_engine.h"
#include "engines/compute_engine.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kParallelSquares = 0.1998248957;  // Howell, C-11

Lattices latticesWithWindows() { return {enginesOf(EngineKind::compute), {}, 0, true}; }

TEST(Guarantee, HoeffdingsDirections) {
  // A single bound has 2 exp(-2 N e^2 / M^2) <= d.
  for (double range : {2.0, 3.7})
    for (double epsilon : {0.1, 1e-3})
      EXPECT_EQ(hoeffdingDirections({range}, {1}, epsilon, 0.01),
                std::ceil(range * range * std::log(2 / 0.01) / (2 * epsilon * epsilon)));
  // With equal ranges the numbers of bounds add up.
  EXPECT_EQ(hoeffdingDirections({2, 2, 2}, {4, 3, 2}, 0.01, 0.01), std::ceil(4 * std::log(2 * 9 / 0.01) / (2e-4)));
  // A much larger range decides alone, for the terms of the others vanish beside it.
  EXPECT_EQ(hoeffdingDirections({2, 20}, {1000, 1}, 0.1, 0.01), std::ceil(400 * std::log(2 / 0.01) / 0.02));
}

TEST(Guarantee, BernsteinsBound) {
  // By hand, L = ln(4 / 0.04) = 4.60517, sqrt(2 0.5 L / 101) = 0.213532 and 7 2 L / 300 = 0.214908.
  EXPECT_NEAR(bernsteinBound(0.5, 2, 101, 0.04), 0.213532 + 0.214908, 2e-6);
}

TEST(Guarantee, EveryFormFactorHasItsBound) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  for (By by : {By::polygon, By::surface}) {
    const Ids ids = makeIds(scene, by, false);
    const auto bounds = countBounds(ids);
    std::vector<uint32_t> polygons(ids.count(), 0);
    for (uint32_t id : ids.of_polygon) ++polygons[id];
    const auto n = double(ids.count()),
               with_itself = double(std::count_if(polygons.begin(), polygons.end(), [](uint32_t k) { return k > 1; }));
    EXPECT_EQ(std::accumulate(bounds.begin(), bounds.end(), 0.0), n * (n - 1) / 2 + 2 * n + with_itself);
  }
}

// If the polygons of a surface lie on two lattices, its pairs are counted on both, and ranges add up.
TEST(Guarantee, RangesAddUpOverLattices) {
  InputScene input{"floor and two plates", {}, {}};
  ts::addFace(input, "floor", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  ts::addFace(input, "plates", {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}});
  ts::addFace(input, "plates", {{0, 0, 2}, {0, 1, 2}, {1, 1, 2}, {1, 0, 2}});
  const Scene scene = buildScene(input);
  const double a = scene.polygons[0].area, p = 4 * std::sqrt(a);
  const auto range = [&](double resolution) {
    return (2 * a + p * 2 / resolution + 8 / (resolution * resolution)) / a;
  };
  const auto rangesFor = [&](By by, const std::vector<double>& resolutions) {
    return formFactorRanges(scene, makeIds(scene, by, false), resolutions, Sampling::lattice);
  };
  const auto one = rangesFor(By::surface, {8, 32, 32}), two = rangesFor(By::surface, {8, 8, 32}),
             each = rangesFor(By::polygon, {8, 8, 32});
  EXPECT_DOUBLE_EQ(one[0], range(8));
  EXPECT_DOUBLE_EQ(one[1], range(32));
  EXPECT_DOUBLE_EQ(two[0], range(8) + range(32));
  // The surface of both plates has twice the area, which halves the ranges. The last term is of the pair of the two
  // plates, which is counted on the finer lattice.
  EXPECT_DOUBLE_EQ(two[1], (range(8) + range(32)) / 2 + range(32) / 2);
  EXPECT_DOUBLE_EQ(each[0], range(8));
}

// No direction adds more than its range, and some add a tenth of it or more. This holds on coarse and fine lattices, in
// windows, with scanlines, on both sides, and by surface.
TEST(Guarantee, SingleDirectionsKeepToTheirRanges) {
  const auto directions = sampleDirections(Sampler::iid, 24, 5, 0);
  for (const InputScene& input : {ts::parallelSquares(), ts::roomWithTouchingBoxes(), ts::triangleSoup(30, 0.6, 2)})
    for (const bool two_sided : {false, true})
      for (const By by : {By::polygon, By::surface})
        for (const auto& [base, sampling] :
             {std::pair(6, Sampling::lattice), std::pair(40, Sampling::lattice), std::pair(6, Sampling::scanline)}) {
          const Scene scene = buildScene(input);
          const Ids ids = makeIds(scene, by, two_sided);
          std::vector<double> needed, resolutions(scene.polygons.size());
          for (const Polygon& polygon : scene.polygons) needed.push_back(3 / std::sqrt(polygon.area));
          const auto groups = groupBySize(scene, needed, base);
          for (const SizeGroup& group : groups)
            for (uint32_t k : group.polygons) resolutions[k] = group.resolution;
          const auto ranges = formFactorRanges(scene, ids, resolutions, sampling);
          const auto engine =
              makeGroupedEngine(enginesOf(EngineKind::compute), scene, ids, {.sampling = sampling}, groups);
          const double unit = engine->unitArea() * scene.scale * scene.scale;
          double largest_share = 0;
          for (const Direction& direction : directions)
            for (const PairCount& c : engine->count(std::span(&direction, 1))) {
              const uint32_t smaller = c.j < kEnvironment && ids.areas[c.j] < ids.areas[c.i] ? c.j : c.i;
              const double share = (c.i == c.j ? 4 : 2) * unit * double(c.count) / ids.areas[smaller] / ranges[smaller];
              EXPECT_LE(share, 1) << input.file << " " << base;
              largest_share = std::max(largest_share, share);
            }
          EXPECT_GT(largest_share, 0.1) << input.file << " " << base;  // ranges are not far too wide
        }
}

// CoinEngine has no geometry. Each direction adds its whole range to F_01 or nothing, which is the largest variance
// possible.
class CoinEngine : public Engine {
 public:
  CoinEngine(double share, double area) : share_(share), area_(area) {}
  PairCounts count(std::span<const Direction> directions) override {
    uint64_t heads = 0;
    for (const Direction& direction : directions)
      heads += direction.offset.x < share_;  // uniform and independent of all other numbers
    return heads ? PairCounts{{0, 1, heads}} : PairCounts{};
  }
  double unitArea() const override { return area_; }

 private:
  double share_, area_;
};

// Returns the number of failures over many seeds. At most a share of delta may fail, within four standard deviations of
// the binomial law. Bounds are not sharp, so far fewer do.
int failures(double share, double epsilon, double delta, int seeds, bool expect_bernstein) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  GuaranteePlan plan;
  plan.epsilon = epsilon;
  plan.delta = delta;
  plan.ranges = {2, 2};
  plan.bounds = 5;
  plan.largest_range = 2;
  plan.hoeffding = hoeffdingDirections(plan.ranges, countBounds(ids), epsilon, delta / 2);
  plan.block_directions = 1;
  plan.most_blocks = plan.hoeffding;
  plan.least_blocks = 50;
  plan.engine = std::make_unique<CoinEngine>(share, ids.areas[0] / (scene.scale * scene.scale));
  int failed = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    GuaranteeOptions options{.epsilon = epsilon, .delta = delta};
    options.sampler = Sampler::iid;
    options.seed = static_cast<uint64_t>(seed);
    const Estimate estimate = guaranteeFormFactors(scene, ids, options, plan);
    failed += std::abs(estimate.form_factors.formFactor(0, 1).value - 2 * share) > epsilon;
    EXPECT_EQ(estimate.guarantee->by == GuaranteedBy::bernstein, expect_bernstein);
    EXPECT_LE(estimate.guarantee->bound, epsilon);
  }
  return failed;
}

TEST(Guarantee, FailsNoMoreOftenThanItMay) {
  constexpr int kSeeds = 150;
  const double allowed = 0.2 * kSeeds + 4 * std::sqrt(0.2 * 0.8 * kSeeds);
  EXPECT_LE(failures(0.5, 0.3, 0.2, kSeeds, false), allowed);
  EXPECT_LE(failures(0.02, 0.04, 0.2, kSeeds, true), allowed);
  EXPECT_LE(failures(0.002, 0.04, 0.2, kSeeds, true), allowed);
}

// By hand, l = ln(2 / 0.02) = 4.60517 and M l / 3 = 3.07011. The bound is (3.07011 + sqrt(3.07011^2 + 2 1000 0.05 l)) /
// 1000.
TEST(Guarantee, BernsteinsBoundOfAGivenVariance) {
  EXPECT_NEAR(givenVarianceBound(0.05, 2, 1000, 0.02), (3.07011 + std::sqrt(3.07011 * 3.07011 + 460.517)) / 1000, 1e-7);
  // The variance is at most M^2 / 4. There Bernstein's bound is twice Hoeffding's or more, for its term in the range is
  // added.
  EXPECT_GT(givenVarianceBound(1, 2, 1e6, 0.02), 2 * std::sqrt(std::log(2 / 0.02) / 2e6));
}

// TwoCoinEngine has no geometry. A direction has its whole range as T = V + O or nothing, and all of T is visible or
// nothing. This is the largest variance for given F0 and F.
class TwoCoinEngine : public Engine {
 public:
  TwoCoinEngine(double lines, double prior_sums, double area) : lines_(lines), visible_(prior_sums), area_(area) {}
  PairCounts count(std::span<const Direction> directions) override {
    PairCount pair{0, 1, 0, 0};
    for (const Direction& direction : directions)
      if (direction.offset.x < lines_) ++(direction.offset.y < visible_ ? pair.count : pair.blocked);
    return pair.count + pair.blocked ? PairCounts{pair} : PairCounts{};
  }
  double unitArea() const override { return area_; }

 private:
  double lines_, visible_, area_;
};

struct VisibilityOutcome {
  int failed = 0;
  uint64_t directions = 0;
};

VisibilityOutcome visibilityFailures(double lines, double prior_sums, double b, double epsilon, double delta, int seeds,
                                     GuaranteedBy by) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  GuaranteePlan plan;
  plan.epsilon = epsilon;
  plan.delta = delta;
  plan.ranges = {2, 2};
  plan.largest_range = 2;
  plan.prior = {{{0, 1, static_cast<uint32_t>(b * kVisibilityOne), 0, 2 * lines * ids.areas[0]}}, {1, 1}, true};
  plan.visibility_bounds.emplace(ids, plan.ranges, plan.prior);
  plan.bounds = 5;
  plan.hoeffding = plan.visibility_bounds->directionsFor(epsilon, delta / 2);
  plan.block_directions = 1;
  plan.most_blocks = plan.hoeffding;
  plan.least_blocks = by == GuaranteedBy::bernstein ? 50 : plan.hoeffding;
  plan.engine = std::make_unique<TwoCoinEngine>(lines, prior_sums, ids.areas[0] / (scene.scale * scene.scale));
  VisibilityOutcome outcome;
  for (int seed = 0; seed < seeds; ++seed) {
    GuaranteeOptions options{.epsilon = epsilon, .delta = delta};
    options.sampler = Sampler::iid;
    options.seed = static_cast<uint64_t>(seed);
    const Estimate estimate = guaranteeFormFactors(scene, ids, options, plan);
    outcome.failed += std::abs(estimate.form_factors.formFactor(0, 1).value - 2 * lines * prior_sums) > epsilon;
    outcome.directions += estimate.directions;
    EXPECT_TRUE(by == GuaranteedBy::bernstein || estimate.guarantee->by == by);  // bernstein: either bound may end it
    EXPECT_LE(estimate.guarantee->bound, epsilon);
  }
  return outcome;
}

// A guarantee holds for any visibility b from the pilot, right or far off, and by either bound. Each run may fail with
// probability 0.2. So of kSeeds runs at most the mean plus four standard deviations of the binomial law may fail.
TEST(Guarantee, WithUnoccludedFormFactorsItFailsNoMoreOftenThanItMay) {
  constexpr int kSeeds = 30;
  const double allowed = 0.2 * kSeeds + 4 * std::sqrt(0.2 * 0.8 * kSeeds);
  for (const double b : {0.0, 0.5, 1.0})
    for (const auto& [lines, prior_sums] : {std::pair(0.05, 0.5), std::pair(0.4, 0.5), std::pair(0.4, 0.98)})
      for (const GuaranteedBy by : {GuaranteedBy::hoeffding, GuaranteedBy::bernstein}) {
        const VisibilityOutcome outcome = visibilityFailures(lines, prior_sums, b, 0.08, 0.2, kSeeds, by);
        EXPECT_LE(outcome.failed, allowed) << b << " " << lines << " " << prior_sums;
      }
}

// The right visibility ends a run sooner than a visibility of 0.
TEST(Guarantee, VisibilitiesEndItSooner) {
  const uint64_t without = visibilityFailures(0.4, 0.98, 0, 0.08, 0.2, 10, GuaranteedBy::bernstein).directions,
                 with = visibilityFailures(0.4, 0.98, 1, 0.08, 0.2, 10, GuaranteedBy::bernstein).directions;
  EXPECT_LT(with, without);
}

// Only environment and leak need the number of directions of Hoeffding's bound. Pairs with small unoccluded form
// factors need fewer.
TEST(Guarantee, UnoccludedFormFactorsNeedNoMoreDirectionsThanHoeffding) {
  Ids ids;
  constexpr uint32_t kIds = 200;
  ids.names.resize(kIds);
  ids.areas.assign(kIds, 1);
  for (uint32_t k = 0; k < kIds; ++k) ids.of_polygon.push_back(k);
  const std::vector<double> ranges(kIds, 2);
  Prior prior{{}, std::vector<uint64_t>(kIds, 1), true};
  for (uint32_t i = 0; i < kIds; ++i)
    for (uint32_t j = i + 1; j < kIds; ++j) prior.pairs.push_back({i, j, kVisibilityOne, 0, 0.005});
  const uint64_t plain = hoeffdingDirections(ranges, countBounds(ids), 0.01, 0.005),
                 with = VisibilityBounds(ids, ranges, prior).directionsFor(0.01, 0.005);
  // 400 bounds take the place of 20,300, which divides the number of directions by ln(2 20300 / 0.005) / ln(2 400 /
  // 0.005).
  EXPECT_NEAR(double(with) / double(plain), std::log(800 / 0.005) / std::log(40600 / 0.005), 1e-3);
  EXPECT_THROW(VisibilityBounds(ids, ranges, prior).directionsFor(1e-6, 0.005), Error);
}

// No direction adds more than its range to V + O, an assumption of the bounds.
TEST(Guarantee, BlockedLinesKeepToTheRangesToo) {
  const auto directions = sampleDirections(Sampler::iid, 24, 5, 0);
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::triangleSoup(30, 0.6, 2)})
    for (const Sampling sampling : {Sampling::lattice, Sampling::scanline}) {
      const Scene scene = buildScene(input);
      const Ids ids = makeIds(scene, By::polygon, false);
      const int resolution = 12;
      const auto ranges =
          formFactorRanges(scene, ids, std::vector<double>(scene.polygons.size(), resolution), sampling);
      const auto engine = makeComputeEngine(testDevice(), scene, ids,
                                            {.resolution = resolution, .sampling = sampling, .count_blocked = true});
      const double unit = engine->unitArea() * scene.scale * scene.scale;
      double largest_share = 0;
      for (const Direction& direction : directions)
        for (const PairCount& c : withRows(engine->count(std::span(&direction, 1)))) {
          const uint32_t smaller = c.j < kEnvironment && ids.areas[c.j] < ids.areas[c.i] ? c.j : c.i;
          const double share = 2 * unit * double(c.count + c.blocked) / ids.areas[smaller] / ranges[smaller];
          EXPECT_LE(share, 1) << input.file;
          largest_share = std::max(largest_share, share);
        }
      EXPECT_GT(largest_share, 0.3) << input.file;
    }
}

// A guarantee with unoccluded form factors is planned, run, stopped and continued. Its value is within epsilon, and
// continuing gives the same bits.
TEST(Guarantee, WithUnoccludedFormFactorsTheWholeChainHolds) {
  const Scene scene = buildScene(ts::perpendicularSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  GuaranteeOptions options{.epsilon = 0.08, .delta = 0.2, .seed = 4};
  options.unoccluded = true;
  options.device = &testDevice();
  const Lattices lattices{enginesOf(EngineKind::compute), {.count_blocked = true}, 0, true, &ids};
  const GuaranteePlan plan = planGuarantee(scene, ids, options, lattices, false);
  ASSERT_TRUE(plan.visibility_bounds);
  std::optional<RunSums> half;
  options.on_sums = [&](const RunSums& sums, bool) {
    if (sums.replicateCount() == plan.least_blocks / 2) half = sums;
  };
  const Estimate whole = guaranteeFormFactors(scene, ids, options, plan);
  // Nothing is between the squares and the pilot finds a visibility of 1, so that only rounding is left.
  EXPECT_NEAR(whole.form_factors.formFactor(0, 1).value, 0.2000437761, 1e-6);
  EXPECT_LE(whole.guarantee->bound, options.epsilon);
  ASSERT_TRUE(half);
  options.resumed = &*half;
  options.on_sums = {};
  const Estimate resumed = guaranteeFormFactors(scene, ids, options, plan);
  EXPECT_EQ(resumed.directions, whole.directions);
  for (uint32_t j : {1u, kEnvironment})
    EXPECT_EQ(resumed.form_factors.exchangeArea(0, j).value, whole.form_factors.exchangeArea(0, j).value);
}

// A guarantee is planned for the scene and run over 12 seeds. It holds the closed form.
TEST(Guarantee, HoldsForTheClosedForm) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  GuaranteeOptions options{.epsilon = 0.1, .delta = 0.2};
  const GuaranteePlan plan = planGuarantee(scene, ids, options, latticesWithWindows(), false);
  EXPECT_GT(plan.largest_range, 2);
  EXPECT_LE(plan.least_blocks, plan.most_blocks);
  EXPECT_GE(plan.most_blocks * plan.block_directions, plan.hoeffding);
  EXPECT_EQ(plan.lemma_1, 500);
  int failed = 0;
  for (options.seed = 0; options.seed < 12; ++options.seed) {
    const Estimate estimate = guaranteeFormFactors(scene, ids, options, plan);
    failed += std::abs(estimate.form_factors.formFactor(0, 1).value - kParallelSquares) > options.epsilon;
  }
  EXPECT_LE(failed, 0.2 * 12 + 4 * std::sqrt(0.2 * 0.8 * 12));
}

TEST(Guarantee, TheMedianOfRunsHoldsToo) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  GuaranteeOptions options{.epsilon = 0.1, .delta = 0.1, .statistic = Statistic::median, .sampler = Sampler::iid};
  const Lattices exact{reference::exactEngines(), {}, 1, false};
  const GuaranteePlan plan = planGuarantee(scene, ids, options, exact, true);
  // Pellegrini 1997, section 5.3, takes Q = 8 ln(5 / delta) runs of 4 / epsilon^2 directions for five form factors at
  // once.
  EXPECT_EQ(plan.run_directions, 400u);
  EXPECT_EQ(plan.runs, 33u);
  const Estimate estimate = guaranteeFormFactors(scene, ids, options, plan);
  EXPECT_EQ(estimate.replicates, 33u);
  EXPECT_EQ(estimate.guarantee->by, GuaranteedBy::median);
  const Measured f = estimate.form_factors.formFactor(0, 1);
  EXPECT_NEAR(f.value, kParallelSquares, options.epsilon);
  EXPECT_NEAR(f.value, kParallelSquares, 5 * f.standard_error);
  EXPECT_EQ(estimate.form_factors.exchangeArea(0, 1).value, estimate.form_factors.exchangeArea(1, 0).value);
  EXPECT_EQ(estimate.between_surfaces.formFactor(0, 1).value, f.value);  // each surface is one polygon
}

TEST(Guarantee, WhatCannotBeKeptIsRefused) {
  const Scene scene = buildScene(ts::parallelSquares());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto plan = [&](const GuaranteeOptions& options) {
    return planGuarantee(scene, ids, options, latticesWithWindows(), false);
  };
  EXPECT_THROW(plan({.epsilon = 0}), Error);
  EXPECT_THROW(plan({.epsilon = 0.1, .delta = 1}), Error);
  EXPECT_THROW(plan({.epsilon = 1e-9}), Error);
  EXPECT_THROW(hoeffdingDirections({2, 1e9}, {1, 1}, 0.1, 0.01), Error);
  EXPECT_THROW(plan({.epsilon = 0.1, .sampler = Sampler::fibonacci}), Error);
  EXPECT_THROW(plan({.epsilon = 0.1, .statistic = Statistic::median, .sampler = Sampler::jittered}), Error);
}

}  // namespace
}  // namespace viewpeel
