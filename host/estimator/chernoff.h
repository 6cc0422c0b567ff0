// chernoffBounds() bounds the mean of independent variables in [0, 1].
#pragma once

namespace viewpeel {

struct MeanBounds {
  double lower = 0, upper = 1;
};

// Returns bounds on the expectation of the mean of n independent variables in [0, 1]. The variables may have different
// laws.
//   The lower bound is the least mu <= mean_low with n KL(mean_low, mu) <= l. The upper bound is the largest
//   mu >= mean_high with n KL(mean_high, mu) <= l. KL(x, y) = x ln(x / y) + (1 - x) ln((1 - x) / (1 - y)).
//   In: mean_low <= mean_high: the observed mean lies between them; n > 0; l = ln(2 / p)
//   Error: rounding widens each bound by at most 1e-9. The probability that either bound fails is at most p.
//   Tests: tests/unit/chernoff_test.cpp.
//   Cost: some 60 logarithms.
//   Source: W. Hoeffding, Probability inequalities for sums of bounded random variables, J. Amer. Statist. Assoc. 58,
//     1963, theorem 1.
MeanBounds chernoffBounds(double mean_low, double mean_high, double n, double l);

}  // namespace viewpeel
