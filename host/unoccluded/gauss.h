// Computes nodes and weights of Gauss-Legendre rules.
#pragma once
#include <vector>

namespace viewpeel {

struct GaussPoint {
  long double node = 0;    // on -1..1
  long double weight = 0;  // sum 2
};

// Returns the rule integral of f over -1..1 = sum_k weight_k f(node_k), exact for polynomials of degree 2n - 1.
//   In: n, 1..128.
//   Out: the points in increasing order.
//   Error: 4 ulp of long double in node and weight; tests/unit/line_rules_test.cpp (monomials).
//   Throws: nothing.
//   Cost: O(n^2).
//   Source: Abramowitz & Stegun, Handbook of Mathematical Functions, 25.4.29; Newton's method on the Legendre
//     recurrence.
std::vector<GaussPoint> gaussPoints(int n);

// Returns the largest error of the rule on the mean of a monomial of degree k = 2n, 2n + 2, ...
//   error = max_k |1 / (k + 1) - sum_i weight_i node_i^k / 2|
//   In: n, 1..100.     Out: the error.
//   Error: rounding; tests/unit/line_rules_test.cpp.
//   Throws: nothing.     Cost: O(n^2 + 200 n).     Source: none.
double largestMonomialError(int n);

}  // namespace viewpeel
