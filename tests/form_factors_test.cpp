#include "matrix/form_factors.h"

#include <cmath>

#include <gtest/gtest.h>

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
  // Mean count 14; sample variance 16, so the mean's standard error is sqrt(16 / 3). A_i F_ij = 2 C_ij.
  EXPECT_DOUBLE_EQ(f.exchangeArea(0, 1).value, 14);
  EXPECT_DOUBLE_EQ(f.exchangeArea(1, 0).standard_error, std::sqrt(16 / 3.0));
  EXPECT_DOUBLE_EQ(f.formFactor(0, 1).value, 7);
  EXPECT_DOUBLE_EQ(f.formFactor(1, 0).value, 3.5);
  EXPECT_DOUBLE_EQ(sums.largestStandardError(0.5), std::sqrt(16 / 3.0) / 2);
}

// An entry that some replicates never met counts as zero in them.
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
  // Rows: id 0 has 6 lines, then 4; id 1 has 5, then 4.
  EXPECT_DOUBLE_EQ(f.rowSums()[0].value, 2 * 5);
  EXPECT_DOUBLE_EQ(f.rowSums()[1].value, 2 * 4.5);
  EXPECT_DOUBLE_EQ(f.rowSums()[1].standard_error, 2 * 0.5);
}

TEST(ReplicateSums, HugeCountsKeepTheirSpread) {
  const uint64_t base = 1ull << 52;
  ReplicateSums sums(twoIds(1, 1));
  for (uint64_t k : {0, 2, 4}) sums.add({{0, 1, base + k}});
  EXPECT_DOUBLE_EQ(sums.formFactors(1).exchangeArea(0, 1).standard_error, 2 * std::sqrt(4 / 3.0));
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
