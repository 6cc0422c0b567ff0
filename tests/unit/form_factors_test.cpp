#include <viewpeel/form_factors.h>
#include "sums/replicate_sums.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <viewpeel/compute.h>
#include "scenes/generate.h"
#include "scenes/triangulated_city.h"

namespace viewpeel {
namespace {

Ids twoIds(double area_0, double area_1) {
  Ids ids;
  ids.names = {"a", "b"};
  ids.areas = {area_0, area_1};
  ids.surface = {0, 0};
  return ids;
}

TEST(ReplicateSums, MeanAndStandardErrorOfThree) {
  ReplicateSums sums(twoIds(2, 4));
  sums.add({{0, 1, 10}});
  sums.add({{0, 1, 14}});
  sums.add({{0, 1, 18}});
  const FormFactors f = sums.formFactors(0.5);
  // By eq. (12) of docs/method.md: the sum K is 42, the sample variance 16, and R s^2 = 48. So D_1 = 48 / 42 and D = 43
  // / 37.75. The mean's standard error is sqrt(48 + (43 / 37.75)^2) / 3, and A_i F_ij = 2 C_ij.
  const double standard_error = std::hypot(std::sqrt(48.0), 43 / 37.75) / 3;
  EXPECT_DOUBLE_EQ(f.exchangeArea(0, 1).value, 14);
  EXPECT_DOUBLE_EQ(f.exchangeArea(1, 0).standard_error, standard_error);
  EXPECT_DOUBLE_EQ(f.formFactor(0, 1).value, 7);
  EXPECT_DOUBLE_EQ(f.formFactor(1, 0).value, 3.5);
  EXPECT_DOUBLE_EQ(sums.largestStandardError(0.5), standard_error / 2);
}

// An entry that some replicates never met counts as zero in these replicates.
TEST(ReplicateSums, MissingEntriesAreZeros) {
  ReplicateSums sums(twoIds(1, 1));
  sums.add({{0, 0, 3}, {1, kEnvironment, 5}});
  sums.add({{0, 1, 4}});
  const FormFactors f = sums.formFactors(1);
  ASSERT_EQ(f.entries().size(), 3u);
  EXPECT_DOUBLE_EQ(f.exchangeArea(0, 0).value, 4 * 1.5);  // a pair within one id exchanges both ways
  EXPECT_DOUBLE_EQ(f.exchangeArea(0, 1).value, 2 * 2);
  EXPECT_DOUBLE_EQ(f.formFactor(1, kEnvironment).value, 2 * 2.5);
  EXPECT_EQ(f.formFactor(0, kLeak).value, 0);
  // Row 0 has 6 lines in the first replicate and 4 in the second, row 1 has 5 and 4.
  EXPECT_DOUBLE_EQ(f.rowSums()[0].value, 2 * 5);
  EXPECT_DOUBLE_EQ(f.rowSums()[1].value, 2 * 4.5);
  EXPECT_DOUBLE_EQ(f.rowSums()[1].standard_error,
                   2 * std::hypot(1.0, 1.0) / 2);  // K = 9: R s^2 = 1; D_1 would be 1/9, but is 1 at least
}

TEST(ReplicateSums, HugeCountsKeepTheirSpread) {
  const uint64_t base = 1ull << 52;
  ReplicateSums sums(twoIds(1, 1));
  for (uint64_t k : {0, 2, 4}) sums.add({{0, 1, base + k}});
  EXPECT_DOUBLE_EQ(sums.formFactors(1).exchangeArea(0, 1).standard_error,
                   2 * std::sqrt(13.0) / 3);  // R s^2 = 12, and D = 1
}

// Replicates that agree seem exact. But any of them might have counted one more, so they have the error of one
// count.
TEST(ReplicateSums, ReplicatesThatAgreeHaveTheErrorOfOneCount) {
  ReplicateSums sums(twoIds(1, 1));
  for (int k = 0; k < 4; ++k) sums.add({{0, 1, 7}});
  EXPECT_DOUBLE_EQ(sums.formFactors(1).exchangeArea(0, 1).standard_error, 2 / 4.0);
}

// Coverages are the shares of 4000 runs, of 8 replicates each, whose 95 % interval holds the expectation. Lines come in
// bunches of equal size.
struct Coverages {
  double printed = 0, by_spread_alone = 0;  // printed: by (12), where D_0 is the size of a bunch
};

Coverages coverBunches(double bunches, uint64_t bunch) {
  constexpr int kRuns = 4000, kReplicates = 8;
  constexpr double kStudent = 2.364624;  // 97.5 %, 7 degrees of freedom
  std::mt19937_64 bits(1);
  const auto poisson =
      [&bits](double expectation) {  // counts uniform factors whose product stays above exp(-expectation)
        uint64_t count = 0;
        for (double product = 1; (product *= double(bits() >> 11) * 0x1p-53) > std::exp(-expectation);) ++count;
        return count;
      };
  const double truth = 2 * bunches * double(bunch) / kReplicates;
  Coverages coverages;
  for (int run = 0; run < kRuns; ++run) {
    ReplicateSums sums(twoIds(1, 1));
    double sum = 0, squares = 0;
    for (int k = 0; k < kReplicates; ++k) {
      const uint64_t count = bunch * poisson(bunches / kReplicates);
      sums.add(count ? PairCounts{{0, 1, count}} : PairCounts{});
      sum += double(count), squares += double(count) * double(count);
    }
    const Measured f = sums.formFactors(1, bunch > 1 ? 8 / 27.0 / double(bunch - 1) : INFINITY).formFactor(0, 1);
    const double spread_alone = 2 * std::sqrt((squares - sum * sum / kReplicates) / (kReplicates - 1) / kReplicates);
    coverages.printed += (std::abs(f.value - truth) <= kStudent * f.standard_error) / double(kRuns);
    coverages.by_spread_alone += (std::abs(f.value - truth) <= kStudent * spread_alone) / double(kRuns);
  }
  return coverages;
}

// The share of 4000 runs has a standard error of 0.34 %. It is 4 standard errors below 95 % for one seed in 16,000.
TEST(ReplicateSums, IntervalsOfFewCountsHoldTheTruth) {
  constexpr double kLeast = 0.95 - 4 * 0.0034;
  for (double lines : {4.0, 8.0, 16.0}) EXPECT_GT(coverBunches(lines, 1).printed, kLeast) << lines << " lines";
  EXPECT_LT(coverBunches(4, 1).by_spread_alone, kLeast);  // negative control: the spread alone fails
  for (double bunches : {4.0, 8.0, 16.0}) {
    const Coverages coverages = coverBunches(bunches, 5);
    EXPECT_GT(coverages.printed, kLeast) << bunches << " bunches";
    EXPECT_GT(coverages.printed, coverages.by_spread_alone) << bunches << " bunches";
  }
}

// One direction met the pair, with one line. Another direction might have met it with many. The smaller polygon has an
// area of 2, and a line stands for an area of 0.1. So 20 lines have room on it, and a direction that sees the pair
// counts D_0 = 1 + 8/27 20 = 6.93 of them in the mean, eq. (12). Where many directions met the pair, D_0 changes
// nothing.
TEST(ReplicateSums, OneDirectionDoesNotTellHowManyLinesOthersSee) {
  const auto errorOf = [](uint64_t count, double count_area) {
    ReplicateSums sums(twoIds(2, 4));
    for (int k = 0; k < 8; ++k) sums.add(k == 0 || count > 1 ? PairCounts{{0, 1, count}} : PairCounts{});
    const FormFactors f = sums.formFactors(1, count_area);
    EXPECT_EQ(f.formFactor(0, 1).standard_error, sums.largestStandardError(1, count_area));
    return f.formFactor(0, 1).standard_error;
  };
  EXPECT_DOUBLE_EQ(errorOf(1, 0.1), std::hypot(1.0, (2 + 160 / 27.0) / 2) / 8);
  EXPECT_DOUBLE_EQ(errorOf(1, INFINITY), std::sqrt(2.0) / 8);
  EXPECT_NEAR(errorOf(1000, 0.1), errorOf(1000, INFINITY), 1e-3 * errorOf(1000, INFINITY));
}

// With at most one line at a time, (13) bounds the probability of a line. For larger polygons the bound no longer
// depends on the area, since a direction meets them with many lines at once.
// A unit of a scanline is 2^-10 of a spacing. Polygons of 1/64 of a spacing to the side have some 724 units of chord at
// most, and a square of four spacings has whole scanlines.
TEST(ReplicateSums, AScanlineAddsItsChord) {
  constexpr double kLine = 1024, kCountArea = 1 / kLine;  // of a lattice whose spacing is 1
  const double small = std::pow(1 / 64.0, 2);
  EXPECT_DOUBLE_EQ(lineStep(kLine, true, small, kCountArea), kLine * std::sqrt(small / 2));
  EXPECT_EQ(lineStep(kLine, true, 16, kCountArea), kLine);
  EXPECT_EQ(lineStep(4, false, small, 1), 4);
  EXPECT_EQ(lineStep(kLine, true, 1e-9, kCountArea), 1);
  // Two replicates that agree err by half of such a line at least.
  ReplicateSums sums(twoIds(small, 16));
  sums.setLineSteps({lineStep(kLine, true, small, kCountArea), kLine});
  sums.add({{0, 1, 5}});
  sums.add({{0, 1, 5}});
  EXPECT_GE(sums.exchangeArea({0, 1, {10, 50}}, 1, kCountArea).standard_error, kLine * std::sqrt(small / 2) / 2);
}

// Many triangles of the city are smaller than a lattice's square. With the spread of counts alone, one in 250 of the
// entries errs by more than five stated errors.
TEST(ReplicateSums, ErrorsHoldForPolygonsSmallerThanASpacing) {
  constexpr double kMostBeyond = 1e-3;
  const Scene scene = buildScene(bench::triangulatedCity(1'000).scene);
  Request request;
  request.goal = FixedAmount{.directions = 256, .replicates = 8}, request.engine = EngineKind::host;
  const FormFactors found = computeFormFactors(scene, request).form_factors;
  request.goal = RootMeanSquare{5e-5}, request.pair_lines = true;
  const FormFactors truth = computeFormFactors(scene, request).form_factors;
  uint64_t beyond = 0, pairs = 0;
  for (const FormFactors::Entry& entry : found.entries()) {
    if (entry.j >= kEnvironment) continue;
    const Measured here = entry.exchange_area, there = truth.exchangeArea(entry.i, entry.j);
    beyond += std::abs(here.value - there.value) > 5 * std::hypot(here.standard_error, there.standard_error);
    ++pairs;
  }
  EXPECT_LE(double(beyond), kMostBeyond * double(pairs));
}

TEST(ReplicateSums, UnmetPairsAreBounded) {
  // (1 - p)^n = 5 % for p = 1 - 0.05^(1/n).
  EXPECT_NEAR(unmetBound(0.5, 2, 1000), 2 * 4 * (1 - std::pow(0.05, 1e-3)), 2e-3 * unmetBound(0.5, 2, 1000));
  EXPECT_DOUBLE_EQ(unmetBound(2, 2, 1000), unmetBound(50, 2, 1000));
}

TEST(ReplicateSums, OneReplicateHasNoStandardError) {
  ReplicateSums sums(twoIds(1, 1));
  sums.add({{0, 1, 1}});
  EXPECT_TRUE(std::isinf(sums.largestStandardError(1)));
}

TEST(MergeIds, AddsUpAndOrdersPairs) {
  const PairCounts merged = mergeIds({{0, 1, 2}, {0, 2, 3}, {1, 2, 5}, {2, kLeak, 7}}, {1, 0, 1});
  ASSERT_EQ(merged.size(), 3u);
  EXPECT_EQ(merged[0].count, 7u);  // (0, 1): 2 + 5
  EXPECT_EQ(merged[1].count, 3u);  // (1, 1)
  EXPECT_EQ(merged[2].j, kLeak);
}

TEST(ReplicateSums, BlockedPairsAddNothing) {
  ReplicateSums sums(twoIds(1, 1));
  for (int k = 0; k < 2; ++k) sums.add({{0, 1, 0, 5}, {0, kEnvironment, 2}});
  const FormFactors factors = sums.formFactors(1);
  ASSERT_EQ(factors.entries().size(), 1u);
  EXPECT_EQ(factors.entries()[0].j, kEnvironment);
}

TEST(MergeIds, AddsUpBlockedPairs) {
  const PairCounts merged = mergeIds({{0, 1, 2, 1}, {0, 2, 0, 3}, {1, 2, 5, 7}}, {1, 0, 1});
  ASSERT_EQ(merged.size(), 2u);
  EXPECT_EQ(merged[0].count, 7u);
  EXPECT_EQ(merged[0].blocked, 8u);
  EXPECT_EQ(merged[1].count, 0u);
  EXPECT_EQ(merged[1].blocked, 3u);
}

}  // namespace
}  // namespace viewpeel
