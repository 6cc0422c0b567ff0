// gaussRule() makes Gauss-Legendre rules. integrate() integrates adaptively over an interval.
#pragma once
#include <functional>
#include <vector>

namespace viewpeel::reference {

// An Approximation is a number with a bound on its error, or an estimate of it.
struct Approximation {
  double value = 0;
  double error = 0;  // bound or estimate, according to the function that returns it
};

struct GaussRule {
  std::vector<long double> nodes, weights;  // on (0, 1)
};

// Returns the Gauss-Legendre rule of n points on (0, 1): sum_k weight_k f(node_k), exact for polynomials of degree 2n -
// 1.
//   In: n, 1..64.
//   Out: the rule: every call returns the same object. Several threads may call the function at once.
//   Error: nodes and weights to 4 ulp of long double; tests/unit/quadrature_test.cpp (monomials).
//   Throws: nothing.
//   Cost: O(n^2) once per n.
//   Source: Abramowitz & Stegun, Handbook of Mathematical Functions, 25.4.29; Newton's method on the Legendre
//   recurrence.
const GaussRule& gaussRule(int n);

struct LineIntegral {
  long double value = 0;
  long double error = 0;  // sum of |16-point - 10-point rule| over the intervals that were not halved
};

// Returns the integral of f over [low, high]. Intervals are halved until the 10-point and the 16-point Gauss rule
// agree.
//   In: f: finite on (low, high), and singular at most like x ln x at the ends; tolerance: absolute; noise: the
//     absolute rounding error of one value of f
//   Out: the integral by the 16-point rules. Its `error` is the sum of the differences of the two rules.
//   Error: `error`, once the intervals resolve the integrand. Halving stops at the tolerance, at the noise, at the
//     rounding of the sum, after 60 halvings at one place, or at 10,000 intervals. Tests:
//     tests/unit/quadrature_test.cpp.
//   Throws: whatever f throws.
//   Cost: 26 calls of f per interval visited; O(log(1/distance of a singularity)) intervals per singularity.
//   Source: the usual adaptive scheme, e.g. Davis & Rabinowitz, Methods of Numerical Integration, 6.2.
LineIntegral integrate(const std::function<long double(long double)>& f, long double low, long double high,
                       long double tolerance, long double noise = 0);

}  // namespace viewpeel::reference
