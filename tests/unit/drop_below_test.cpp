// These tests leave small form factors out of a matrix; each row keeps the sum of the ones it lost.
#include <cmath>

#include <gtest/gtest.h>

#include <viewpeel/drop_below.h>

namespace viewpeel {
namespace {

// Returns rows of areas 1, 2 and 10: F_01 = 0.3, F_02 = 0.004, F_20 = 0.0004, F_12 = 0.002, F_21 = 0.0004, F_22 =
// 0.001.
FormFactors example(bool with_intervals) {
  Ids ids;
  ids.names = {"a", "b", "c"};
  ids.areas = {1, 2, 10};
  ids.surface = {0, 1, 2};
  std::vector<FormFactors::Entry> entries = {
      {0, 1, {0.3, 3e-3}},   {0, 2, {0.004, 4e-4}}, {0, kEnvironment, {1e-5, 1e-6}},
      {1, 2, {0.004, 3e-4}}, {2, 2, {0.01, 1e-3}},  {2, kLeak, {1e-5, 0}}};
  std::vector<Interval> intervals;
  if (with_intervals)
    for (const FormFactors::Entry& entry : entries) intervals.push_back({0, 1.5 * entry.exchange_area.value});
  return {ids, entries, {{0.9, 0.1}, {0.8, 0.1}, {0.7, 0.1}}, intervals, with_intervals ? 1e-4 : 0};
}

TEST(DropBelow, RowsKeepWhatWasLeftOut) {
  const DroppedBelow result = dropBelow(example(false), 0.003);
  // F_02 is above the bound, so the pair stays in both directions. Environment and leak always stay.
  EXPECT_EQ(result.dropped.pairs, 2u);
  ASSERT_EQ(result.kept.entries().size(), 4u);
  EXPECT_DOUBLE_EQ(result.kept.formFactor(2, 0).value, 0.0004);
  EXPECT_EQ(result.kept.formFactor(1, 2).value, 0);
  EXPECT_EQ(result.kept.formFactor(0, kEnvironment).value, 1e-5);
  EXPECT_DOUBLE_EQ(result.kept.formFactor(2, kLeak).value, 1e-6);
  EXPECT_EQ(result.dropped.sums[0].value, 0);
  EXPECT_DOUBLE_EQ(result.dropped.sums[1].value, 0.002);
  EXPECT_DOUBLE_EQ(result.dropped.sums[2].value, 0.0004 + 0.001);
  EXPECT_DOUBLE_EQ(result.dropped.sums[2].standard_error, std::hypot(3e-5, 1e-4));
  // The row sums are sums over the whole matrix.
  EXPECT_EQ(result.kept.rowSums()[2].value, 0.7);
}

TEST(DropBelow, ABoundBelowAllKeepsAll) {
  const DroppedBelow result = dropBelow(example(false), 1e-9);
  EXPECT_EQ(result.dropped.pairs, 0u);
  EXPECT_EQ(result.kept.entries().size(), example(false).entries().size());
}

// The interval of a pair that was left out still holds the form factor that the pair has in the whole matrix.
TEST(DropBelow, IntervalsOfWhatWasLeftOutHoldIt) {
  const FormFactors whole = example(true);
  const DroppedBelow result = dropBelow(whole, 0.003);
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t j = 0; j < 3; ++j) {
      EXPECT_LE(result.kept.interval(i, j).lower, whole.formFactor(i, j).value);
      EXPECT_GE(result.kept.interval(i, j).upper, whole.formFactor(i, j).value) << i << ' ' << j;
    }
  EXPECT_EQ(result.kept.interval(0, 1).upper, whole.interval(0, 1).upper);
}

}  // namespace
}  // namespace viewpeel
