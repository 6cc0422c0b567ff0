// These tests add up facing and blocked lines with visibilities fixed beforehand, and check the standard errors of the
// sums.
#include <cmath>
#include <random>

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "sums/control_variate_sums.h"
#include "scenes/named_scenes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

TEST(ControlVariateSums, WithoutVisibilityTheyAreReplicateSums) {
  const Scene scene = buildScene(ts::roomWithTouchingBoxes());
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeComputeEngine(testDevice(), scene, ids, {.resolution = 24, .count_blocked = true});
  ReplicateSums plain(ids);
  ControlVariateSums controls(ids);
  for (uint64_t r = 0; r < 5; ++r) {
    const PairCounts counts = engine->count(sampleDirections(Sampler::fibonacci, 20, 1, r));
    plain.add(counts);
    controls.add(takeControlVariates(counts, {}));
  }
  const FormFactors a = plain.formFactors(0.01), b = controls.formFactors(0.01, {});
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (size_t k = 0; k < a.entries().size(); ++k) {
    EXPECT_EQ(a.entries()[k].i, b.entries()[k].i);
    EXPECT_EQ(a.entries()[k].j, b.entries()[k].j);
    // Both sides round a dozen operations, one in double, the other in long double.
    EXPECT_NEAR(a.entries()[k].exchange_area.value, b.entries()[k].exchange_area.value,
                1e-14 * a.entries()[k].exchange_area.value);
  }
}

TEST(ControlVariateSums, ByHand) {
  const std::vector<PairVisibility> visibilities{{0, 1, kVisibilityOne / 4}};
  const PairCounts first{{0, 1, 3, 5}, {0, 2, 2}, {0, kEnvironment, 7}}, second{{0, 1, 1, 11}};
  const auto controls = takeControlVariates(first, visibilities);
  ASSERT_EQ(controls.size(), 3u);
  EXPECT_EQ(controls[0].control, (3 - 0.25 * 8) * kVisibilityOne);
  EXPECT_EQ(controls[0].squares, ControlVariate::Wide((3 * 0.5625 + 5 * 0.0625) * kVisibilityOne * kVisibilityOne));
  EXPECT_EQ(controls[1].control, 2 * kVisibilityOne);
  EXPECT_EQ(controls[2].control, 7 * kVisibilityOne);
  const auto merged = mergeIds(controls, {0, 1, 1});
  ASSERT_EQ(merged.size(), 2u);
  EXPECT_EQ(merged[0].control, 3 * kVisibilityOne);

  Ids ids;
  ids.names = {"a", "b", "c"};
  ids.areas = {1, 1, 1};
  ControlVariateSums sums(ids);
  sums.add(controls);
  sums.add(takeControlVariates(second, visibilities));
  // The control variates of (0, 1) are 1 and -2, with a mean of -0.5 and a variance of the sum of 2 x 4.5 = 9. Squares
  // are 2 + 1.25 lines, so that lines come 9 / 3.25 at a time in (12), and D_0 = 1.
  const Measured f = sums.formFactors(0.5, {{0, 1, 4, 16}}).exchangeArea(0, 1);
  EXPECT_DOUBLE_EQ(f.value, 3.5);
  EXPECT_DOUBLE_EQ(f.standard_error, std::hypot(3, 4.25 / (3.25 * 3.25 / 9 + 1)) / 2);
  // The value is moved into [0, F0].
  EXPECT_EQ(sums.formFactors(0.5, {{0, 1, 0.25, 16}}).exchangeArea(0, 1).value, 0);
  EXPECT_EQ(sums.formFactors(0.5, {{0, 1, 17, 16}}).exchangeArea(0, 1).value, 16);
  // A pair with a prior that no line met has an entry, with the standard error of one line.
  const Measured unmet = sums.formFactors(0.5, {{1, 2, 4, 4}}).exchangeArea(1, 2);
  EXPECT_EQ(unmet.value, 4);
  EXPECT_EQ(unmet.standard_error, 0.5);
}

// Environment is a share of all lines of its row, so withRows() counts the other lines of the row as blocked.
TEST(ControlVariateSums, RowsHaveAllTheirLines) {
  const PairCounts counts = withRows({{0, 1, 3, 5}, {0, kEnvironment, 6}, {1, 2, 4}, {1, kLeak, 1}});
  ASSERT_EQ(counts.size(), 4u);
  EXPECT_EQ(counts[0].blocked, 5u);
  EXPECT_EQ(counts[1].blocked, 3u);
  EXPECT_EQ(counts[2].blocked, 0u);
  EXPECT_EQ(counts[3].blocked, 7u);
  // No line leaves row 0 in this replicate, but other replicates saw one. All lines of the row then count as blocked. A
  // row without lines gets no entry.
  const std::vector<PairVisibility> others{{0, kEnvironment, 7}, {0, kLeak, 7}, {1, 2, 7}, {3, kLeak, 7}};
  const PairCounts filled = withRows({{0, 1, 3, 5}, {0, kEnvironment, 6}, {1, 2, 4}}, others);
  ASSERT_EQ(filled.size(), 4u);
  EXPECT_EQ(filled[1].blocked, 3u);
  EXPECT_EQ(filled[2].j, kLeak);
  EXPECT_EQ(filled[2].count, 0u);
  EXPECT_EQ(filled[2].blocked, 9u);
}

// One line of the coarser of two lattices, or one scanline, adds several counts: 16 of pair (0, 2) here, and 1 of pair
// (0, 1). A pair's standard error is no less than the exchange area of one line: its counts times 0.5, the area a
// count.
TEST(ControlVariateSums, LinesOfSeveralCounts) {
  const auto controls = takeControlVariates({{0, 1, 64}, {0, 2, 64}, {1, kEnvironment, 16}}, {}, {16, 1, 64});
  EXPECT_EQ(controls[0].line, 1u);  // the finer of the two lattices
  EXPECT_EQ(controls[1].line, 16u);
  EXPECT_EQ(controls[1].squares, ControlVariate::Wide(4 * 16 * 16) * kVisibilityOne * kVisibilityOne);
  EXPECT_EQ(controls[2].line, 1u);
  EXPECT_EQ(mergeIds(controls, {0, 1, 1})[0].line, 16u);
  Ids ids;
  ids.names = {"a", "b", "c"};
  ids.areas = {1, 1, 1};
  ControlVariateSums sums(ids);
  sums.add(controls);
  sums.add(controls);
  EXPECT_EQ(sums.formFactors(0.5, {}).exchangeArea(0, 1).standard_error, 0.5);
  EXPECT_EQ(sums.formFactors(0.5, {}).exchangeArea(0, 2).standard_error, 8);
  // A pair whose F0 is below one line has no standard error above F0.
  EXPECT_EQ(sums.formFactors(0.5, {{1, 2, 0, 3, 16}}).exchangeArea(1, 2).standard_error, 3);
  EXPECT_THROW(takeControlVariates({{0, 1, uint64_t(1) << 51}}, {}), Error);
}

// Replicates without spread still have an error. In the pilot the visibility b was 1 (never blocked) or 0 (never seen).
// In eight replicates some of `lines` lines are blocked, or seen, all the same: a number of Poisson's law with mean m.
// Intervals of 95 % are t = 2.36 standard errors of at least one line. They miss the truth if no line shows it and m >
// 2.36, with a probability of at most e^-2.36 = 9.4 %. They also miss it where the spread of few lines is too small, as
// for plain counts (docs/accuracy.md, coverage).
TEST(ControlVariateSums, NothingSeenIsNotNothingThere) {
  std::mt19937_64 random(6);
  constexpr int kTrials = 4000, kReplicates = 8;
  const double t = quantile(complement(boost::math::students_t(kReplicates - 1), 0.025));
  Ids ids;
  ids.names = {"a", "b"};
  ids.areas = {1, 1};
  for (const bool never_blocked : {true, false})
    for (const double m : {0.01, 0.1, 0.5, 1.0, 2.0, 3.0, 6.0, 16.0, 40.0}) {
      constexpr uint64_t kLines = 1000;
      std::poisson_distribution<uint64_t> few(m / kReplicates);
      int held = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        ControlVariateSums sums(ids);
        for (int r = 0; r < kReplicates; ++r) {
          const uint64_t rare = few(random);
          sums.add(
              takeControlVariates({{0, 1, never_blocked ? kLines - rare : rare, never_blocked ? rare : kLines - rare}},
                                  {{0, 1, never_blocked ? kVisibilityOne : 0}}));
        }
        const double all = 2 * kLines, truth = 2 * (never_blocked ? kLines - m / kReplicates : m / kReplicates);
        const Measured f = sums.formFactors(1, {{0, 1, never_blocked ? all : 0, all}}).exchangeArea(0, 1);
        held += std::abs(f.value - truth) <= t * f.standard_error;
      }
      // The bound leaves four standard deviations of the binomial law.
      EXPECT_GE(held, kTrials * 0.88 - 4 * std::sqrt(0.88 * 0.12 * kTrials)) << never_blocked << " " << m;
      if (m < 16) continue;
      EXPECT_GE(held, kTrials * 0.94 - 4 * std::sqrt(0.94 * 0.06 * kTrials)) << never_blocked << " " << m;
    }
}

// Squares of counts of 2^62 fit into 128 bits 15 times, and not 16 times. The sum is refused then, whether replicates
// or sums are added.
TEST(ControlVariateSums, SquaresBeyond128BitsAreRefused) {
  Ids ids;
  ids.names = {"a", "b"};
  ids.areas = {1, 1};
  const PairCounts most{{0, 1, kMostCounts, 0}};
  ControlVariateSums sums(ids), eight(ids);
  for (int k = 0; k < 15; ++k) sums.add(takeControlVariates(most, {}));
  for (int k = 0; k < 8; ++k) eight.add(takeControlVariates(most, {}));
  EXPECT_EQ(sums.pairs()[0].sum_of_squares, ControlVariateSums::Wide(15) << 124);
  EXPECT_THROW(sums.add(takeControlVariates(most, {})), Error);
  ControlVariateSums both = eight;
  EXPECT_THROW(both.add(eight), Error);
  EXPECT_THROW(takeControlVariates({{0, 1, kMostCounts + 1, 0}}, {}), Error);
}

}  // namespace
}  // namespace viewpeel
