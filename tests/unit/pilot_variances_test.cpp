// These tests compare how a plan expects variances to fall with the number of directions with how they fall.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "directions/sampler.h"
#include "estimator/pilot_variances.h"

namespace viewpeel {
namespace {

// Returns the variance of the mean over `count` directions of a function on a cap: 1 in all of it, or a slope from 1 at
// the pole to 0 at the rim. The area that two polygons share in projection is between the two: it falls to 0 with the
// direction, but occluders cut into it.
double varianceOfCap(double share, bool is_slope, uint32_t count) {
  constexpr uint64_t kReplicates = 1500;
  const double rim = std::acos(1 - 2 * share);
  double sum = 0, squares = 0;
  for (uint64_t r = 0; r < kReplicates; ++r) {
    double mean = 0;
    for (const Direction& direction : sampleDirections(Sampler::fibonacci, count, 1, r)) {
      const double angle = std::acos(std::clamp(double(direction.u.z), -1.0, 1.0));
      mean += (is_slope ? std::max(0.0, 1 - angle / rim) : double(angle < rim)) / count;
    }
    sum += mean, squares += mean * mean;
  }
  return (squares - sum * sum / kReplicates) / (kReplicates - 1);
}

// While few directions meet a cap, variances fall as 1 / N for both functions; later as N^-1.5 for the jump, and as
// N^-3 for the slope. The formula is between the two. Where m = 1.28 directions meet the cap in the mean, a lattice has
// either one or two of them there. Its variance is 0.2 in place of m / (1 + m), 2.8 times less. The rarest cap is met
// in 48 of 1,500 replicates, which gives its variance to 25 %.
TEST(VarianceLeft, IsBetweenAJumpAndASlope) {
  constexpr double kWithin = 3;
  for (const double share : {0.002, 0.02, 0.2}) {
    const double jump = varianceOfCap(share, false, 16), slope = varianceOfCap(share, true, 16);
    for (const uint32_t count : {64, 256, 1024}) {
      const double expected = varianceLeft(16 * share, count / 16.0);
      EXPECT_GT(varianceOfCap(share, false, count) / jump, expected / kWithin) << share << " " << count;
      EXPECT_LT(varianceOfCap(share, true, count) / slope, expected * kWithin) << share << " " << count;
    }
  }
}

// The pair of the largest variance in the pilot, which all replicates met, is not the one of the largest variance with
// more directions.
TEST(VarianceLeft, RarePairsTakeOver) {
  PilotVariances largest{.by_meetings = std::vector<double>(9, 0.0)};
  largest.by_meetings[8] = 2;
  largest.by_meetings[1] = 1;  // m = -log(7/8) = 0.1335
  EXPECT_NEAR(varianceLeft(largest, 16), 0.5 * (1 + 0.13353) / (16 * (1 + 16 * 0.13353)), 1e-5);
  largest.by_meetings[1] = 0;
  EXPECT_NEAR(varianceLeft(largest, 16), (1 + 2.77259) / (16 * (1 + 16 * 2.77259)), 1e-5);
  EXPECT_EQ(varianceLeft(largest, 1), 1);
  EXPECT_EQ(varianceLeft(PilotVariances{.by_meetings = std::vector<double>(9, 0.0)}, 4), 1);  // no form factor varied
}

// The mean of variances falls as the sum of its parts does.
TEST(VarianceLeft, OfAMeanIsTheMean) {
  PilotVariances mean{.are_means = true, .by_meetings = std::vector<double>(9, 0.0)};
  mean.by_meetings[8] = 2, mean.by_meetings[1] = 1;
  const double often = (1 + 2.77259) / (16 * (1 + 16 * 2.77259)), seldom = (1 + 0.13353) / (16 * (1 + 16 * 0.13353));
  EXPECT_NEAR(varianceLeft(mean, 16), (2 * often + seldom) / 3, 1e-6);
}

}  // namespace
}  // namespace viewpeel
