// Line integrals have these rules, with bounds on their errors.
#pragma once
#include <array>
#include <cstdint>

#include "unoccluded/gauss.h"

namespace viewpeel {

// A LineRound is one round over the near pairs. It has the points of the three plain rules and of the graded one. The
// plain ones are for pieces that are ever nearer to each other (`clear` > 12, 3.5, 1.5 in
// shaders/unoccluded/edges.comp).
//   Error: of int_p int_q ln r ds dt, in units of |p| |q|. A plain rule of n points has 4 r^-2n, docs/method.md,
//     section 11, "Near pairs". The graded one has graded_error wherever the inner integral is singular, but above p's
//     inside. Measured: at most 0.7 of either; tests/unit/line_rules_test.cpp.
struct LineRound {
  std::array<uint32_t, 4> points;
  double graded_error;
};
constexpr std::array<LineRound, 3> kLineRounds{
    {{{4, 7, 12, 24}, 1e-8}, {{8, 14, 24, 44}, 3e-11}, {{16, 28, 48, 128}, 2e-16}}};

// A Gauss rule on 0..1 in t, graded towards both ends by x = t^3 (10 - 15 t + 6 t^2): x ln x becomes t^5 ln t.
//   In: n, 1..128.
//   Out: nodes x on 0..1, weights of sum 1.
//   Error: as gaussPoints.
//   Throws: nothing.
//   Cost: O(n^2).
//   Source: P. Davis & P. Rabinowitz, Methods of Numerical Integration, 2.12.
std::vector<GaussPoint> gradedPoints(int n);

// Returns the plain rule on 0..1; everything else as gaussPoints.
std::vector<GaussPoint> unitPoints(int n);

}  // namespace viewpeel
