// Directed pairs, which common directions hardly meet, have separate directions. These tests show that their form
// factors are unbiased, their errors right and their bits reproducible, and that runs take less time.
#include <cmath>
#include <numbers>

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include <viewpeel/error.h>
#include "estimator/directed_pairs.h"
#include "estimator/find_prior.h"
#include "reference/exact/exact_engine.h"
#include "reference/closed_forms/past_blocker.h"
#include "scenes/named_scenes.h"
#include "scenes/shared_engine.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

struct Directed {
  Scene scene;
  Ids ids;
  LatticeOptions lattice;
  std::unique_ptr<Engine> engine;
  std::vector<SizeGroup> groups;
  std::map<std::pair<int, double>, std::unique_ptr<Engine>> pair_engines;  // by resolution and radius of the window

  explicit Directed(const InputScene& input, const LatticeOptions& options = {.resolution = 64})
      : scene(buildScene(input)), ids(makeIds(scene, By::polygon, false)), lattice(options) {
    lattice.count_blocked = true;
    groups = groupAsOne(scene, lattice.resolution);
    engine = makeComputeEngine(testDevice(), scene, ids, lattice);
  }
  PairSampler sampler(uint64_t seed) {
    return PairSampler(
        scene, ids, seed,
        [this](const Scene& of, const Ids& pair_ids, const LatticeOptions& options) {
          std::unique_ptr<Engine>& made =
              pair_engines[{options.resolution, options.window.radius}];  // pairs with other windows have other engines
          if (!made) made = makeComputeEngine(testDevice(), of, pair_ids, options);
          return std::make_unique<SharedEngine>(*made);
        },
        lattice);
  }
  FoundPrior find(EstimateOptions options, PairSampler* pairs) {
    options.pairs = pairs;
    FaceExchanges exchanges(&testDevice(), scene, ids);
    return findPrior(*engine, exchanges, scene, ids, groups, options, {choosePriorPilot(options).directions});
  }
  Estimate estimate(EstimateOptions options, const FoundPrior& found, PairSampler* pairs) {
    options.prior = &found.prior;
    options.pairs = pairs;
    return estimateFormFactors(*engine, scene, ids, options);
  }
};

double truthPastTheEdge() {
  const InputScene input = ts::squaresPastAnEdge();
  return reference::formFactorPastBlocker(input.faces[0].corners, input.faces[1].corners, input.faces[2].corners).value;
}

const EstimateOptions kGoal{.directions = 256, .relative = 0.05, .relative_floor = 1e-5};

// Facing lattice points times the solid angle of (25) give the form factor, and all points the unoccluded one. Means
// over 400 replicates are compared within allowedStandardErrors of them. An engine with exact areas has no lattice, and
// gives the same.
TEST(DirectedPairs, CountsStandForTheirSolidAngle) {
  Directed made(ts::squaresPastAnEdge());
  const double truth = truthPastTheEdge(), area = made.ids.areas[0];
  const double whole = made.find({.directions = 64}, nullptr).prior.pairs[0].exchange / area;
  PairSampler lattice = made.sampler(3);
  PairSampler exact(made.scene, made.ids, 3, reference::exactEngines());
  constexpr uint64_t kReplicates = 400;
  for (PairSampler* sampler : {&lattice, &exact}) {
    DirectedPair pair = sampler->direct(0, 1, 16);
    EXPECT_EQ(pair.directions, 16u);
    sampler->prepare({&pair, 1});
    ReplicateSums::Sum facing, all;
    const double f = 2 * pair.measure_area / area;
    double sum[2] = {0, 0}, squares[2] = {0, 0};
    for (uint64_t r = 0; r < kReplicates; ++r) {
      const PairCount count = sampler->count(pair, r);
      const double values[] = {f * double(count.count), f * double(count.count + count.blocked)};
      for (int k = 0; k < 2; ++k) sum[k] += values[k], squares[k] += values[k] * values[k];
    }
    for (int k = 0; k < 2; ++k) {
      const double mean = sum[k] / kReplicates,
                   error = std::sqrt((squares[k] / kReplicates - mean * mean) / (kReplicates - 1));
      EXPECT_TRUE(isEstimateOf({mean, error}, k ? whole : truth, kReplicates,
                               k ? kUnoccludedRelativeError * whole : reference::kPastBlockerError))
          << k;
      EXPECT_LT(error, 0.05 * mean);
    }
  }
}

// These runs go from pilot to result, over 24 seeds. The pilot chooses this pair alone. The mean is the truth within
// four standard errors. The number of 95 % intervals that hold it is within four standard deviations of the binomial
// law. bench/programs/coverage.cpp has 200 seeds.
TEST(DirectedPairs, AgreeWithTheTruthOverSeeds) {
  Directed made(ts::squaresPastAnEdge());
  const double truth = truthPastTheEdge(), t = quantile(complement(boost::math::students_t(7), 0.025));
  constexpr int kSeeds = 24;
  double sum = 0, squares = 0;
  int held = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    EstimateOptions options = kGoal;
    options.seed = seed;
    PairSampler pairs = made.sampler(seed);
    const FoundPrior found = made.find(options, &pairs);
    ASSERT_EQ(found.prior.directed.size(), 1u) << seed;
    EXPECT_EQ(std::pair(found.prior.directed[0].i, found.prior.directed[0].j), std::pair(0u, 1u));
    options.relative.reset();
    const Estimate e = made.estimate(options, found, &pairs);
    EXPECT_EQ(e.replicates, 8u);
    EXPECT_EQ(e.directed_directions, 8u * found.prior.directed[0].directions);
    const Measured f = e.form_factors.formFactor(0, 1);
    held += std::abs(f.value - truth) <= t * f.standard_error;
    sum += f.value - truth;
    squares += std::pow(f.value - truth, 2);
    EXPECT_EQ(e.form_factors.exchangeArea(0, 1).value, e.form_factors.exchangeArea(1, 0).value);
    EXPECT_GE(f.value, 0);
    EXPECT_LE(f.value, std::min(1.0, made.ids.areas[1] / made.ids.areas[0]));
  }
  EXPECT_LE(std::abs(held - 0.95 * kSeeds), 4 * std::sqrt(0.95 * 0.05 * kSeeds));
  EXPECT_LE(std::abs(sum / kSeeds), 4 * std::sqrt(squares) / kSeeds);
}

// The run reaches its goal with less than a fifth of the directions that it takes without directions for single pairs.
// The fifth is no bound but what the method is for; both runs have fixed seeds.
TEST(DirectedPairs, ReachTheGoalSooner) {
  Directed made(ts::squaresPastAnEdge());
  EstimateOptions goal = kGoal;
  goal.relative = 0.15;
  PairSampler pairs = made.sampler(goal.seed);
  const Estimate with = made.estimate(goal, made.find(goal, &pairs), &pairs),
                 without = made.estimate(goal, made.find(goal, nullptr), nullptr);
  EXPECT_LE(with.largest_relative_error, 0.15);
  EXPECT_LE(without.largest_relative_error, 0.15);
  EXPECT_LT(5 * (with.directions + with.directed_directions), without.directions);
  EXPECT_TRUE(areEstimatesOfTheSame(with.form_factors.formFactor(0, 1), without.form_factors.formFactor(0, 1),
                                    with.replicates));
  // Each surface is one polygon, so the values between surfaces are the same.
  EXPECT_EQ(with.form_factors.exchangeArea(0, 1).value, with.between_surfaces.exchangeArea(0, 1).value);
  EXPECT_EQ(with.form_factors.exchangeArea(0, 1).standard_error,
            with.between_surfaces.exchangeArea(0, 1).standard_error);
  // Row sums come from common directions, and differ from 1 by the error of these directions.
  EXPECT_TRUE(isEstimateOf(with.form_factors.rowSums()[0], 1, with.replicates));
}

// Pairs of one emitter share an engine. Their counts equal the counts of separate engines.
TEST(DirectedPairs, PairsOfOneEmitterShareAnEngine) {
  InputScene input = ts::squaresPastAnEdge();
  ts::addFace(input, "beside", {{1, 0, 6}, {1, 0.6, 6}, {1.6, 0.6, 6}, {1.6, 0, 6}});
  ts::addFace(input, "above", {{-0.6, 0, 0.5}, {-0.6, 0.6, 0.5}, {0, 0.6, 0.5}, {0, 0, 0.5}});
  const Scene scene = buildScene(input);
  const Ids ids = makeIds(scene, By::polygon, false);
  int engines = 0;
  const EngineFactory make = [&](const Scene& of, const Ids& pair_ids, LatticeOptions options) {
    options.batch_directions = ++engines % 2 ? 3u : 0u;
    return makeComputeEngine(testDevice(), of, pair_ids, options);
  };
  PairSampler together(scene, ids, 5, make);
  std::vector<DirectedPair> pairs{together.direct(0, 3, 20), together.direct(0, 4, 50)};
  EXPECT_EQ(together.countEngines(pairs), 1u);
  together.prepare(pairs);
  EXPECT_EQ(engines, 1);
  const PairCounts counts = together.count(pairs, 7);
  ASSERT_EQ(counts.size(), 2u);
  for (size_t k = 0; k < pairs.size(); ++k) {
    PairSampler alone(scene, ids, 5, make);
    DirectedPair pair = alone.direct(pairs[k].i, pairs[k].j, pairs[k].directions);
    alone.prepare({&pair, 1});
    EXPECT_EQ(pair, pairs[k]);
    EXPECT_EQ(alone.count(pair, 7), counts[k]);
    EXPECT_NE(alone.count(pair, 8), counts[k]);
    PairSampler other_seed(scene, ids, 6, make);
    other_seed.prepare({&pair, 1});
    EXPECT_NE(other_seed.count(pair, 7), counts[k]);
  }
  // Where engines have no finer lattice the pair takes the finest one.
  EXPECT_GT(pairs[0].resolution, 50u);
  EXPECT_EQ(PairSampler(scene, ids, 5, make, {}, 50).direct(0, 3, 20).resolution, 50u);
  // Squares that look the same way do not see each other, and get no directions.
  EXPECT_EQ(together.direct(1, 3, 10).directions, 0u);
}

// A pair that is never blocked has its unoccluded form factor, and a pair that is always blocked has 0. Both have the
// error of one line on their own lattice, h^2 |W| / (2 pi) over the number of directions.
TEST(DirectedPairs, NeverAndAlwaysBlockedAreExact) {
  for (const bool is_blocked : {false, true}) {
    Directed made(is_blocked ? ts::squaresPastAnEdge(0.9) : ts::stackOfSheets({0, 9}));
    PairSampler pairs = made.sampler(1);
    FoundPrior found = made.find({.directions = 256}, nullptr);
    DirectedPair pair = pairs.direct(0, 1, 64);
    pairs.prepare({&pair, 1});
    pair.visibility = is_blocked ? 0 : kVisibilityOne;
    found.prior.directed = {pair};
    const double whole = found.prior.pairs[0].exchange;
    std::optional<FormFactors> all;
    const EstimateOptions options{
        .directions = 16, .replicates = 4, .on_sums = [&](const RunSums& sums, bool) { all = sums.formFactors(); }};
    const Estimate e = made.estimate(options, found, &pairs);
    const Measured f = all->exchangeArea(0, 1);
    EXPECT_EQ(f.value, is_blocked ? 0 : whole);
    const DirectionRegion region = findPairRegion(made.scene, std::vector{0u}, std::vector{1u});
    const double h = 2 * made.scene.scale / pair.resolution,
                 line = 2 * h * h * region.solidAngle() / (2 * std::numbers::pi) / (64 * 4);
    EXPECT_NEAR(f.standard_error, line, 1e-12 * line);
    EXPECT_LT(f.standard_error, 1e-3 * whole);
    EXPECT_EQ(e.unseen_pairs, is_blocked ? 1u : 0u);
    EXPECT_EQ(e.largest_unseen_error, is_blocked ? f.standard_error / made.ids.areas[0] : 0);
  }
}

// A resumed run, or one merged from parts, has the bits of a run without a stop. Parts merge if they chose the same
// pairs.
TEST(DirectedPairs, AreSumsLikeAnyOther) {
  Directed made(ts::squaresPastAnEdge());
  PairSampler pairs = made.sampler(1);
  const FoundPrior found = made.find(kGoal, &pairs);
  ASSERT_EQ(found.prior.directed.size(), 1u);
  const auto run = [&](uint64_t first, uint32_t replicates, const RunSums* resumed, PairSampler* sampler) {
    std::optional<RunSums> sums;
    EstimateOptions options{.directions = 64,
                            .replicates = replicates,
                            .first_replicate = first,
                            .resumed = resumed,
                            .on_sums = [&](const RunSums& s, bool) { sums = s; }};
    made.estimate(options, found, sampler);
    return *sums;
  };
  const auto isSame = [](const RunSums& a, const RunSums& b) {
    const FormFactors x = a.formFactors(), y = b.formFactors();
    return x.exchangeArea(0, 1).value == y.exchangeArea(0, 1).value &&
           x.exchangeArea(0, 1).standard_error == y.exchangeArea(0, 1).standard_error &&
           x.exchangeArea(0, 1).standard_error > 0 &&
           a.prior_sums->directed().pairs()[0].sum == b.prior_sums->directed().pairs()[0].sum;
  };
  const RunSums whole = run(0, 6, nullptr, &pairs), begun = run(0, 3, nullptr, &pairs);
  PairSampler fresh = made.sampler(1);
  EXPECT_TRUE(isSame(run(0, 6, &begun, &fresh), whole));
  RunSums later = run(3, 3, nullptr, &pairs);
  EXPECT_FALSE(isSame(later, whole));
  later.add(begun);
  EXPECT_TRUE(isSame(later, whole));
  EXPECT_THROW(run(0, 6, &begun, nullptr), Error);
}

// No pair gets directions of its own without a goal, or where many directions meet every pair.
TEST(DirectedPairs, OnlyWhereTheyPay) {
  Directed made(ts::squaresPastAnEdge());
  PairSampler pairs = made.sampler(1);
  EXPECT_TRUE(made.find({.directions = 256}, &pairs).prior.directed.empty());
  EXPECT_TRUE(made.find({.directions = 256, .tolerance = 0.1}, &pairs).prior.directed.empty());
  Directed near(ts::roomWithTouchingBoxes());
  PairSampler near_pairs = near.sampler(1);
  EXPECT_TRUE(near.find({.directions = 256, .tolerance = 3e-3}, &near_pairs).prior.directed.empty());
}

}  // namespace
}  // namespace viewpeel
