// These functions bound the error of sums of lines in strata: docs/method.md, eq. (52) and (54). The difference of the
// two lines of each cell gives the variance.
#pragma once

namespace viewpeel {

// StrataFigures describe a sum over cells, each of which has two independent lines. A line adds x times its weight to
// the sum; x lies in an interval of length 1.
struct StrataFigures {
  double squares = 0;  // T of section 14: sum over cells of (weight (x1 - x2))^2
  double weight = 0;   // q of section 14: the largest weight of a line
  double cells = 0;    // n of section 14
};

// Returns a bound on the variance of the sum, which is the expectation of `squares`: eq. (52).
//   In: l = ln(1 / p)    Error: the bound fails with probability p at most
//   Method: squares are independent variables in [0, weight^2], to which Chernoff's bound applies (chernoff.h)
//   Tests: tests/unit/strata_bounds_test.cpp.
double boundVariance(const StrataFigures& of, double l);

// Returns t such that a sum of independent variables is above its expectation by more than t with probability
// e^-l at most, and below it by as much.
//   In: variance: v, of the sum, or a bound on it; largest: b, the farthest that a variable is from its expectation
//   Tests: tests/unit/strata_bounds_test.cpp.    Cost: some 60 logarithms.
//   Source: G. Bennett, Probability inequalities for the sum of independent random variables, J. Amer. Statist. Assoc.
//     57, 1962: P <= exp(-(v / b^2) h(b t / v)), h(u) = (1 + u) ln(1 + u) - u
double bennettDeviation(double variance, double largest, double l);

// Returns how far the sum is from its expectation at most, eq. (54) with the variance bounded by eq. (52). On either
// side this fails with probability 2 e^-l at most.
double boundDeviation(const StrataFigures& of, double l);

}  // namespace viewpeel
