// These tests compare Chernoff's bounds with exact binomial tails.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/chernoff.h"

namespace viewpeel {
namespace {

// Returns P(X <= k) for the number X of successes in n trials of probability s, as a sum of exponentials of logarithms.
double binomialTail(int n, int k, double s) {
  double sum = 0;
  for (int m = 0; m <= k; ++m)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(m + 1.0) - std::lgamma(n - m + 1.0) + m * std::log(s) +
                    (n - m) * std::log1p(-s));
  return sum;
}

TEST(Chernoff, ExactTailsAreBelowTheProbabilityOfTheBound) {
  // Let s be the upper bound that k of n successes give. If s were the true probability, k or fewer successes would
  // occur with probability p / 2 at most. So the bound fails with at most this probability.
  for (const double p : {0.05, 1e-3, 1e-8}) {
    const double l = std::log(2 / p);
    for (const int n : {1, 5, 40, 1000})
      for (int k = 0; k < n; k += 1 + n / 23) {
        const MeanBounds bounds = chernoffBounds(double(k) / n, double(k) / n, n, l);
        EXPECT_LE(binomialTail(n, k, bounds.upper), p / 2 * (1 + 1e-9)) << n << ' ' << k;
        // The bound is no looser than Hoeffding's.
        EXPECT_LE(bounds.upper, double(k) / n + std::sqrt(l / (2 * n)) + 1e-9);
        EXPECT_GE(bounds.upper, double(k) / n);
        const MeanBounds mirrored = chernoffBounds(1 - double(k) / n, 1 - double(k) / n, n, l);
        EXPECT_NEAR(mirrored.lower, 1 - bounds.upper, 1e-9);
      }
  }
}

TEST(Chernoff, ABoundThatIsATenthTooSmallFails) {
  // Negative control: nine tenths of the bound fail with more than p / 2 where no trial succeeds.
  const double p = 0.05, l = std::log(2 / p);
  const int n = 40;
  const double upper = chernoffBounds(0, 0, n, l).upper;
  EXPECT_GT(binomialTail(n, 0, 0.9 * upper), p / 2);
}

TEST(Chernoff, LinesThatAreOpenWidenTheBounds) {
  const MeanBounds narrow = chernoffBounds(0.3, 0.3, 100, 5), wide = chernoffBounds(0.25, 0.35, 100, 5);
  EXPECT_LT(wide.lower, narrow.lower);
  EXPECT_GT(wide.upper, narrow.upper);
  EXPECT_DOUBLE_EQ(chernoffBounds(0, 1, 100, 5).lower, 0);
  EXPECT_DOUBLE_EQ(chernoffBounds(0, 1, 100, 5).upper, 1);
}

}  // namespace
}  // namespace viewpeel
