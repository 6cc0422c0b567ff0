// These functions compare estimates with their truths, each with its false-alarm rate.
#pragma once
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <gtest/gtest.h>

#include "estimator/estimate.h"

namespace viewpeel {

// A right estimate fails one comparison with this chance. About a thousand are made in a run of all tests, with seeds
// fixed. A failure after a change is a fault with odds of a million to one for each comparison.
constexpr double kFalseAlarmRate = 1e-6;

// A mean over replicates differs from its expectation by at most this many of its standard errors, but for
// kFalseAlarmRate: Student's distribution with replicates - 1 degrees of freedom. Replicates are sums over many
// directions, so that they are close to normal.
inline double allowedStandardErrors(uint64_t replicates) {
  const boost::math::students_t distribution(double(replicates - 1));
  return quantile(complement(distribution, kFalseAlarmRate / 2));
}

// Returns whether `measured` may be an estimate of `truth`. `truth_error` bounds the error of truth itself. A pair
// without a line has standard error 0.
inline testing::AssertionResult isEstimateOf(const Measured& measured, double truth, uint64_t replicates,
                                             double truth_error = 0) {
  const double bound =
      allowedStandardErrors(replicates) * measured.standard_error + truth_error + 4e-15 * std::abs(truth);
  if (std::abs(measured.value - truth) <= bound) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "estimate " << measured.value << ", standard error " << measured.standard_error
                                     << ", of " << truth << ": differs by " << measured.value - truth << ", bound "
                                     << bound;
}

// Returns whether two independent estimates may be of the same truth. Welch's number of degrees of freedom is at least
// as large as of either alone.
inline testing::AssertionResult areEstimatesOfTheSame(const Measured& a, const Measured& b, uint64_t replicates) {
  return isEstimateOf({a.value, std::hypot(a.standard_error, b.standard_error)}, b.value, replicates);
}

}  // namespace viewpeel
