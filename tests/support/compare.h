// These functions compare estimates with the truth, at a stated false-alarm rate.
#pragma once
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <gtest/gtest.h>

#include "estimator/estimate.h"

namespace viewpeel {

// A correct estimate fails one comparison with this probability. A run of all tests makes about a thousand comparisons,
// with fixed seeds. A failure after a change is a fault with odds of a million to one for each comparison.
constexpr double kFalseAlarmRate = 1e-6;

// Returns a number of standard errors. A mean over replicates differs from its expectation by more than this with
// probability kFalseAlarmRate. It is Student's quantile with replicates - 1 degrees of freedom. Replicates are sums
// over many directions, and so close to normal.
inline double allowedStandardErrors(uint64_t replicates) {
  const boost::math::students_t distribution(double(replicates - 1));
  return quantile(complement(distribution, kFalseAlarmRate / 2));
}

// Returns whether `measured` may be an estimate of `truth`, which itself is off by truth_error at most. A pair without
// a line has a standard error of 0.
inline testing::AssertionResult isEstimateOf(const Measured& measured, double truth, uint64_t replicates,
                                             double truth_error = 0) {
  const double bound =
      allowedStandardErrors(replicates) * measured.standard_error + truth_error + 4e-15 * std::abs(truth);
  if (std::abs(measured.value - truth) <= bound) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "estimate " << measured.value << ", standard error " << measured.standard_error
                                     << ", of " << truth << ": differs by " << measured.value - truth << ", bound "
                                     << bound;
}

// Returns whether two independent estimates may have one truth. Welch's number of degrees of freedom is at least that
// of either estimate.
inline testing::AssertionResult areEstimatesOfTheSame(const Measured& a, const Measured& b, uint64_t replicates) {
  return isEstimateOf({a.value, std::hypot(a.standard_error, b.standard_error)}, b.value, replicates);
}

}  // namespace viewpeel
