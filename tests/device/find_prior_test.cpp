// Form factors that are unoccluded form factors times visibilities are exact where nothing is between two polygons.
// Elsewhere their standard errors are right.
#include <cmath>
#include <map>
#include <optional>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include "engines/host_engine.h"
#include "estimator/find_prior.h"
#include "sums/neighbour_visibility.h"
#include "sums/row_sums.h"
#include "reference/closed_forms/past_blocker.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

constexpr double kParallelSquares = 0.1998248957, kPerpendicularSquares = 0.2000437761, kTenDigits = 5e-11;

struct PriorScene {
  Scene scene;
  Ids ids;
  std::unique_ptr<Engine> engine;
  std::vector<SizeGroup> groups;
  // Adds up the counts of all replicates.
  PairCount countsOf(const EstimateOptions& options, uint32_t i, uint32_t j) const {
    PairCount sum{i, j};
    for (uint64_t r = 0; r < options.replicates; ++r)
      for (const PairCount& count :
           engine->count(sampleDirections(options.sampler, options.directions, options.seed, r)))
        if (count.i == i && count.j == j) sum.add(count);
    return sum;
  }
  FoundPrior find(const EstimateOptions& options) const {
    FaceExchanges exchanges(&testDevice(), scene, ids);
    return findPrior(*engine, exchanges, scene, ids, groups, options, {choosePriorPilot(options).directions});
  }
  Estimate estimate(EstimateOptions options, By by = By::polygon) const {
    const FoundPrior found = find(options);
    options.prior = &found.prior;
    options.by = by;
    return estimateFormFactors(*engine, scene, ids, options);
  }
};

PriorScene makePriorScene(const InputScene& input, int resolution, Sampling sampling = Sampling::lattice) {
  PriorScene made{buildScene(input), {}, nullptr, {}};
  made.ids = makeIds(made.scene, By::polygon, false);
  made.groups = groupAsOne(made.scene, resolution);
  made.engine = makeComputeEngine(testDevice(), made.scene, made.ids,
                                  {.resolution = resolution, .sampling = sampling, .count_blocked = true});
  return made;
}

// Returns the standard error of the visibility of a pair whose lines are all facing or all blocked, by (22) in
// docs/method.md with q = 1. The variance is p (1 - p) / (n + 1/2) of the n directions that see the pair. Here p joins
// two lines of the neighbours' visibility s and a tenth of a line of either kind. The spread of replicates is 0. It has
// the weight r^2 / (r^2 + 1/4) with r = n p (1 - p). The rest has more degrees of freedom than R replicates, at least
// 8, and is scaled so that t standard errors are an interval.
double deviationOfOneKind(const RunSums& sums, uint32_t i, uint32_t j) {
  const VisibilitySums& by_face = sums.prior_sums->byFace();
  const Prior& prior = sums.prior_sums->prior();
  const auto counted = std::ranges::find(by_face.pairs(), std::pair(i, j),
                                         [](const VisibilitySums::PairSum& pair) { return std::pair(pair.i, pair.j); });
  const VisibilitySums::Squares squared = by_face.squaresOf(*counted);
  const double lines = double(counted->facing + counted->blocked), squares = double(squared.facing + squared.blocked),
               area = std::min(by_face.ids().areas[i], by_face.ids().areas[j]);
  const double per_direction = double(lineOf(prior.lines, i, j)) + 8 / 27.0 * area / sums.countArea(),
               n = std::max(lines * lines / squares, lines / per_direction);
  const double s = NeighbourVisibility(by_face, prior.lines, prior.ranks).of(i, j).smoothed;
  const double p = ((counted->facing > 0 ? n : 0) + 2 * s + 0.1) / (n + 2.2), rarer = n * p * (1 - p);
  const double t =
      quantile(complement(boost::math::students_t(double(std::max<uint64_t>(sums.replicateCount(), 8) - 1)), 0.025));
  return std::sqrt(0.25 / (rarer * rarer + 0.25) * p * (1 - p) / (n + 0.5)) *
         quantile(complement(boost::math::normal(), 0.025)) / t;
}

// Pairs that are never blocked have their unoccluded form factor, on any lattice and with any number of directions.
TEST(FindPrior, UnblockedPairsAreExact) {
  for (const auto& [input, truth] : {std::pair(ts::parallelSquares(), kParallelSquares),
                                     std::pair(ts::perpendicularSquares(), kPerpendicularSquares)}) {
    for (const auto& [sampling, replicates] : {std::pair(Sampling::lattice, 4u), std::pair(Sampling::scanline, 24u)}) {
      const PriorScene made = makePriorScene(input, 16, sampling);
      EstimateOptions options{.directions = 24, .replicates = replicates};
      double deviation = 0;
      options.on_sums = [&](const RunSums& sums, bool last) {
        if (last) deviation = deviationOfOneKind(sums, 0, 1);
      };
      const Measured f = made.estimate(options).form_factors.formFactor(0, 1);
      EXPECT_NEAR(f.value, truth, kUnoccludedRelativeError * truth + kTenDigits);
      // Lines cannot prove that no blocker is there, so the error is not 0.
      EXPECT_GT(deviation, 0);
      EXPECT_NEAR(f.standard_error, deviation * f.value,
                  1e-11 * deviation);  // 1 - p is rounded to 2^-53, and is 0.1 / n or more with n up to 1e4
    }
  }
  const Estimate cube = makePriorScene(ts::insideOfCube(), 16).estimate({.directions = 24, .replicates = 4});
  for (uint32_t i = 0; i < 6; ++i)
    for (uint32_t j = 0; j < 6; ++j) {
      const double truth = i == j ? 0 : i / 2 == j / 2 ? kParallelSquares : kPerpendicularSquares;
      EXPECT_NEAR(cube.form_factors.formFactor(i, j).value, truth, kUnoccludedRelativeError * truth + kTenDigits);
    }
}

// Where pilots saw no blocked line all pairs are exact, also pairs that few lines or none met.
TEST(FindPrior, NothingInBetweenIsExactForEveryPair) {
  const PriorScene made = makePriorScene(ts::squaresInParts(2, 1, 4), 4);
  const EstimateOptions options{.directions = 8, .replicates = 2};
  const FoundPrior found = made.find(options);
  const FormFactors few = made.estimate(options).form_factors;
  size_t pairs = 0;
  for (const PairPrior& pair : found.prior.pairs) {
    if (pair.j >= kEnvironment) continue;
    ++pairs;
    EXPECT_NEAR(few.exchangeArea(pair.i, pair.j).value, pair.exchange, 1e-12 * pair.exchange);
  }
  EXPECT_EQ(pairs, 16u);
}

double truthPastTheBlocker() {
  const InputScene input = ts::squaresPastABlocker();
  return reference::formFactorPastBlocker(input.faces[0].corners, input.faces[1].corners, input.faces[2].corners).value;
}

// Partly blocked pairs are unbiased, and have less error than by counts alone. Their 95 % intervals hold the truth in
// 95 of 100 runs, within four standard deviations of the binomial law.
void requireThatPartlyBlockedPairsAreSampledWell(Sampling sampling) {
  const PriorScene made = makePriorScene(ts::squaresPastABlocker(), 24, sampling);
  const double truth = truthPastTheBlocker();
  constexpr int kSeeds = 60;
  const double t = quantile(complement(boost::math::students_t(7), 0.025));
  double squares = 0, plain_squares = 0, sum = 0;
  int held = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const EstimateOptions options{.directions = 64, .seed = seed};
    const Measured f = made.estimate(options).form_factors.formFactor(0, 1);
    const double plain =
        estimateFormFactors(*made.engine, made.scene, made.ids, options).form_factors.formFactor(0, 1).value;
    held += std::abs(f.value - truth) <= t * f.standard_error;
    sum += f.value - truth;
    squares += std::pow(f.value - truth, 2);
    plain_squares += std::pow(plain - truth, 2);
  }
  EXPECT_LE(std::abs(held - 0.95 * kSeeds), 4 * std::sqrt(0.95 * 0.05 * kSeeds));
  EXPECT_LE(std::abs(sum / kSeeds), 5 * std::sqrt(squares) / kSeeds);
  // If both variances were equal, their quotient F(60, 60) would stay below 2.3 with probability 0.999. So the variance
  // is smaller indeed.
  EXPECT_LT(2.3 * squares, plain_squares);
}

TEST(FindPrior, PartlyBlockedPairsAreSampledWell) { requireThatPartlyBlockedPairsAreSampledWell(Sampling::lattice); }

TEST(FindPrior, PartlyBlockedPairsByScanlines) { requireThatPartlyBlockedPairsAreSampledWell(Sampling::scanline); }

// Two squares see only each other. F to the environment is the rest of the row, and more exact than by counts alone.
TEST(FindPrior, WhatLeavesTheSceneIsExactBesideExactPairs) {
  const PriorScene made = makePriorScene(ts::parallelSquares(), 16);
  const EstimateOptions options{.directions = 400};
  const Estimate with = made.estimate(options),
                 without = estimateFormFactors(*made.engine, made.scene, made.ids, options);
  const Measured f = with.form_factors.formFactor(0, kEnvironment),
                 plain = without.form_factors.formFactor(0, kEnvironment);
  EXPECT_TRUE(isEstimateOf(f, 1 - kParallelSquares, options.replicates));
  EXPECT_LT(f.standard_error, plain.standard_error);
}

// With eight lines in all, most pairs get none. A pair without lines has the neighbours' visibility with its spread. If
// a pair has blocked lines alone, its standard error is at most the distance to its unoccluded form factor.
TEST(FindPrior, UnmetPairsAreUncertain) {
  const PriorScene made = makePriorScene(ts::roomWithTouchingBoxes(), 4);
  const EstimateOptions options{.directions = 1, .replicates = 2};
  const FoundPrior found = made.find(options);
  EXPECT_TRUE(found.prior.has_all_pairs);
  std::optional<RunSums> counted;
  EstimateOptions watched = options;
  watched.on_sums = [&](const RunSums& sums, bool last) {
    if (last) counted = sums;
  };
  const Estimate few = made.estimate(watched);
  // These values are from before guesses are adjusted to their rows.
  const FormFactors with_unseen(
      made.ids, counted->prior_sums->ofPriorPairs(counted->measure_area, counted->countArea(), counted->by_id), {});
  const NeighbourVisibility neighbours(counted->prior_sums->byFace(), counted->prior_sums->prior().lines,
                                       found.prior.ranks);
  size_t unmet = 0, blocked_pairs = 0, is_zero = 0;
  for (const PairPrior& pair : found.prior.pairs) {
    const PairCount counts = made.countsOf(options, pair.i, pair.j);
    const Measured f = with_unseen.exchangeArea(pair.i, pair.j);
    if (pair.j >= kEnvironment || counts.count > 0) continue;
    const double area = std::min(made.ids.areas[pair.i], made.ids.areas[pair.j]), most = std::min(pair.exchange, area);
    EXPECT_GE(few.largest_standard_error, f.standard_error / area);
    if (counts.blocked > 0) {
      ++blocked_pairs;
      const auto lines = double(counts.blocked);  // a line is one count here
      EXPECT_NEAR(f.value, lines < 4 ? 0.5 * neighbours.of(pair.i, pair.j).mean / (lines + 0.5) * most : 0,
                  1e-14 * most);  // rounding
      is_zero += f.value == 0;
      const double deviation = deviationOfOneKind(*counted, pair.i, pair.j) * most;
      EXPECT_NEAR(f.standard_error, std::min(deviation, most - f.value), 1e-14 * most);  // rounding
      continue;
    }
    ++unmet;
    const NeighbourVisibility::Value visibility = neighbours.of(pair.i, pair.j);
    EXPECT_NEAR(f.value, visibility.mean * most, 1e-14 * most);  // rounding
    EXPECT_NEAR(f.standard_error, visibility.deviation() * most, 1e-14 * most);
    EXPECT_GT(f.standard_error, 0);
  }
  EXPECT_GT(unmet, 20u);
  EXPECT_GT(blocked_pairs, 0u);
  EXPECT_EQ(few.unmet_pairs, unmet);
  EXPECT_GE(few.unseen_pairs, is_zero);
  EXPECT_TRUE(std::none_of(few.form_factors.entries().begin(), few.form_factors.entries().end(),
                           [](const auto& entry) { return entry.exchange_area.value == 0; }));
  // Adjusted guesses (40) bring row sums nearer to 1, and keep standard errors. The mean square distance has to halve
  // at least: a row gains the share f_i of its lack (41), which measured entries with large errors reduce.
  const FormFactors fitted = counted->formFactors();
  const std::vector<Measured> before = sumRows(with_unseen.entries(), made.ids.areas);
  double off_before = 0, off = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    off_before += std::pow(before[i].value - 1, 2);
    off += std::pow(fitted.rowSums()[i].value - 1, 2);
    EXPECT_DOUBLE_EQ(fitted.rowSums()[i].standard_error, before[i].standard_error);
  }
  EXPECT_LT(off, 0.5 * off_before);
  // Every pair that lines meet has a prior.
  const Estimate many = estimateFormFactors(*made.engine, made.scene, made.ids, {.directions = 2000});
  for (const auto& entry : many.form_factors.entries()) {
    if (entry.j >= kEnvironment) continue;
    EXPECT_TRUE(std::any_of(found.prior.pairs.begin(), found.prior.pairs.end(),
                            [&](const PairPrior& pair) { return pair.i == entry.i && pair.j == entry.j; }))
        << entry.i << " " << entry.j;
  }
}

// Form factors between surfaces are sums over polygons of the same lines. They agree with counts alone.
TEST(FindPrior, SurfacesAndClosedRooms) {
  const PriorScene made = makePriorScene(ts::roomWithTouchingBoxes(), 48);
  const EstimateOptions options{.directions = 400};
  const Estimate by_surface = made.estimate(options, By::surface),
                 plain = estimateFormFactors(*made.engine, made.scene, made.ids, options);
  // With unoccluded form factors pairs without an entry cannot see each other. Without them, a pair without an entry
  // may not have been met.
  EXPECT_TRUE(std::isinf(by_surface.unmet_bound));
  EXPECT_LT(plain.unmet_bound, 1);
  const uint32_t n = by_surface.form_factors.ids().count();
  EXPECT_EQ(n, makeIds(made.scene, By::surface, false).count());
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j)
      EXPECT_TRUE(areEstimatesOfTheSame(by_surface.form_factors.formFactor(i, j),
                                        plain.between_surfaces.formFactor(i, j), options.replicates))
          << i << " " << j;
  const Estimate by_polygon = made.estimate(options);
  for (const auto& entry : by_polygon.form_factors.entries()) {
    const auto& areas = made.ids.areas;
    EXPECT_GE(entry.exchange_area.value, 0);
    EXPECT_LE(entry.exchange_area.value, entry.j < kEnvironment ? std::min(areas[entry.i], areas[entry.j]) : INFINITY);
    EXPECT_TRUE(areEstimatesOfTheSame(by_polygon.form_factors.formFactor(entry.i, entry.j),
                                      plain.form_factors.formFactor(entry.i, entry.j), options.replicates));
  }
  EXPECT_LT(by_polygon.largest_standard_error, plain.largest_standard_error);
}

}  // namespace
}  // namespace viewpeel
