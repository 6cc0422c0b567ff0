// gaussPoints computes nodes and weights of Gauss-Legendre rules.
#pragma once
#include <vector>

namespace viewpeel {

struct GaussPoint {
  long double node = 0;    // place in [-1, 1]
  long double weight = 0;  // weights of a rule add up to 2
};

// Returns the points of the rule  int_-1^1 f dx = sum_k weight_k f(node_k),  which is exact for polynomials of degree
// up to 2n - 1.
//   In: n: number of points, 1 to 128
//   Out: GaussPoint[n], in increasing order of nodes
//   Error: 4 ulp of long double in nodes and weights; tests/unit/line_rules_test.cpp (monomials).
//   Throws: nothing.
//   Cost: O(n^2).
//   Source: Abramowitz & Stegun, Handbook of Mathematical Functions, 25.4.29; Newton's method on the Legendre
//     recurrence.
std::vector<GaussPoint> gaussPoints(int n);

// Returns the largest error of the rule of n points on the mean of x^k over [-1, 1], for k = 2n, 2n + 2, ...
//   error = max_k |1 / (k + 1) - sum_i weight_i node_i^k / 2|
//   In: n: 1 to 100     Out: the error
//   Error: rounding; tests/unit/line_rules_test.cpp.
//   Throws: nothing.     Cost: O(n^2 + 200 n).     Source: none.
double largestMonomialError(int n);

}  // namespace viewpeel
