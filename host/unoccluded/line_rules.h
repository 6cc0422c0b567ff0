// The line integrals of near pairs use these rules, which have bounds on their errors.
#pragma once
#include <array>
#include <cstdint>

#include "unoccluded/gauss.h"

namespace viewpeel {

// A LineRound has the numbers of points of the three plain rules and of the graded rule. Pairs whose bound on the error
// is too large in one round go on to the next. The three plain rules are for edges that are nearer and nearer to each
// other: `clear` > 12, > 3.5 and > 1.5 in shaders/unoccluded/edges.comp.
//   Error: of int_p int_q ln r ds dt, in units of |p| |q|: 4 r^-2n for a plain rule of n points, docs/method.md,
//     section 11, "Near pairs"; graded_error for the graded rule, wherever the inner integral is singular except above
//     the inside of p. Measured errors are at most 0.7 of either bound; tests/unit/line_rules_test.cpp.
struct LineRound {
  std::array<uint32_t, 4> points;
  double graded_error;
};
constexpr std::array<LineRound, 3> kLineRounds{
    {{{4, 7, 12, 24}, 1e-8}, {{8, 14, 24, 44}, 3e-11}, {{16, 28, 48, 128}, 2e-16}}};

// Returns a rule on [0, 1] that is graded towards both ends: a Gauss rule in t with x = t^3 (10 - 15 t + 6 t^2). A
// singularity like x ln x of the integrand then becomes t^5 ln t.
//   In: n: number of points, 1 to 128
//   Out: GaussPoint[n]: nodes x in [0, 1]; weights add up to 1
//   Error: of nodes and weights, as gaussPoints.
//   Throws: nothing.
//   Cost: O(n^2).
//   Source: P. Davis & P. Rabinowitz, Methods of Numerical Integration, 2.12.
std::vector<GaussPoint> gradedPoints(int n);

// Returns the Gauss rule on [0, 1], whose weights add up to 1; otherwise as gaussPoints.
std::vector<GaussPoint> unitPoints(int n);

}  // namespace viewpeel
