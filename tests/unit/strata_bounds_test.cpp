// These tests compare bounds for sums over strata with exact tails of their own laws.
#include <cmath>

#include <boost/math/distributions/binomial.hpp>
#include <gtest/gtest.h>

#include "estimator/strata_bounds.h"

namespace viewpeel {
namespace {

double binomial(int n, int k, double s) {
  return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) + k * std::log(s) +
                  (n - k) * std::log1p(-s));
}

double tailAbove(int n, double least, double s) {
  double sum = 0;
  for (int k = n; k >= 0 && double(k) > least; --k) sum += binomial(n, k, s);
  return sum;
}

// A sum of n lines of weight 1 that face each other with probability s varies by n s (1 - s).
TEST(StrataBounds, DeviationsHoldExactBinomialTails) {
  for (const double l : {1.0, 3.0, 10.0, 18.0})
    for (const int n : {1, 7, 60, 3000})
      for (const double s : {1e-3, 0.03, 0.5, 0.9}) {
        const double variance = n * s * (1 - s), t = bennettDeviation(variance, 1, l);
        EXPECT_LE(tailAbove(n, n * s + t, s), std::exp(-l)) << n << ' ' << s << ' ' << l;
        EXPECT_LE(t, std::sqrt(2 * variance * l) + l / 3 + 1e-9);  // Bernstein
        // Weights scale the bound.
        EXPECT_NEAR(bennettDeviation(variance * 0.01, 0.1, l), 0.1 * t, 1e-5 * t);
      }
}

// For many lines of variance v the probability beyond a deviation t is that of the normal law. With z = t / sqrt(v) it
// is exp(-z^2 / 2) / (z sqrt(2 pi)), and Bennett's bound is exp(-z^2 / 2). Beyond nine tenths of t lies more than e^-l.
TEST(StrataBounds, ADeviationThatIsATenthTooSmallFails) {
  const int n = 2'000'000;
  const double s = 0.5, l = 18, t = bennettDeviation(n * s * (1 - s), 1, l), z = 0.9 * t / std::sqrt(n * s * (1 - s));
  EXPECT_GT(std::erfc(z / std::sqrt(2.0)) / 2, std::exp(-l));
  EXPECT_LT(std::erfc(z / 0.9 / std::sqrt(2.0)) / 2, std::exp(-l));
}

// The two lines of a cell differ with probability 2 s (1 - s). Let v be the bound that m cells of n give. If the
// variance were v, m or fewer cells would differ with probability e^-l at most.
TEST(StrataBounds, VariancesHoldExactTails) {
  for (const double l : {1.0, 3.0, 15.0})
    for (const int n : {3, 40, 1000})
      for (int m = 0; m < n / 2; m += 1 + n / 19) {
        const double weight = 0.25,
                     bound = boundVariance({.squares = m * weight * weight, .weight = weight, .cells = double(n)}, l),
                     differ = bound / (weight * weight * n);
        if (differ >= 1) continue;
        const double tail = 1 - tailAbove(n, m, differ);
        EXPECT_LE(tail, std::exp(-l) * (1 + 1e-6) + 1e-12) << n << ' ' << m;
        // Negative control: a bound a tenth too small is exceeded more often where no cell differs, which is exact.
        EXPECT_GT(m == 0 ? std::pow(1 - 0.9 * differ, n) : 1, std::exp(-l)) << n;
        EXPECT_GE(bound, m * weight * weight);
      }
}

// Returns the probability that the sum of n cells of two coins of chance 1/2 is above its expectation by more than
// `share` of its own bound. Of m cells both coins differ, and add 1 each; of the others a half add 2, the rest 0.
double failureOfCoins(int n, double l, double share) {
  const boost::math::binomial differing(n, 0.5);
  double failure = 0;
  // Beyond nine standard deviations the rest is below 1e-18.
  for (int m = n / 2 - int(4.5 * std::sqrt(n)); m <= n / 2 + int(4.5 * std::sqrt(n)); ++m) {
    const double bound = boundDeviation({.squares = double(m), .weight = 1, .cells = double(n)}, l),
                 most = std::floor((n + share * bound - m) / 2);
    failure += boost::math::pdf(differing, m) *
               (most < n - m ? boost::math::cdf(complement(boost::math::binomial(n - m, 0.5), most)) : 0);
  }
  return failure;
}

// Cells of coins have an exact law, so that this tail is not drawn but added up. A bound a tenth too small fails more
// often than 2 e^-l, at an l of guarantees. Runs could not show it. Where a few of 1,000 runs fail, bounds are too wide
// by more than a tenth, for the factor 1 / (z sqrt(2 pi)) of the normal law alone.
TEST(StrataBounds, OfCoinsATenthTooSmallFail) {
  constexpr int kCells = 400'000;
  constexpr double kL = 25;
  EXPECT_LE(failureOfCoins(kCells, kL, 1), 2 * std::exp(-kL));
  EXPECT_GT(failureOfCoins(kCells, kL, 0.9), 2 * std::exp(-kL));
}

}  // namespace
}  // namespace viewpeel
