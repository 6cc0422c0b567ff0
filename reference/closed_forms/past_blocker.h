// This header has the form factor of two convex polygons past a third.
#pragma once
#include <span>

#include <glm/vec3.hpp>

#include "reference/closed_forms/quadrature.h"

namespace viewpeel::reference {

constexpr double kPastBlockerError = 1e-7;

// Returns F from polygon a to polygon b, fronts only, with one blocker that stops light on both of its sides:
//   F = 1/A int_a (f(x, b) - f(x, b within the blocker's shadow from x)) dx,
//   2 pi f(x, polygon) = - sum_k angle(r_k, r_k+1) n . (r_k x r_k+1) / |r_k x r_k+1|,   r_k = corner_k - x (Lambert).
// a is first cut along every line where a corner of b passes an edge of the blocker, or the other way round. It is cut
// along the blocker's plane, too: on each piece the integrand is analytic. Under edges close to a it still changes
// within their height, so a is cut there in growing strips too. Triangles of the pieces are halved, the worst first.
//   In: three convex planar polygons of 3 or more corners, one unit; a and b counter-clockwise seen from the front. The
//       blocker may touch or cross either; the part of it behind the plane of a or b stops nothing, nor does one within
//       the plane of a; within the plane of b it covers b.
//   Out: F from a to b, 1, and the sum of |5 x 5-point - 3 x 3-point rule| over the triangles plus the area lost in
//   cuts.
//   Error: at most `error`, which is below kPastBlockerError: the difference bounds the error of the worse rule. Gaps
//     down to 1e-12 of the size included. tests/unit/past_blocker_test.cpp.
//   Throws: Error bad_input (a degenerate polygon); Error limit (kPastBlockerError not reached in 200,000 triangles).
//   Cost: m = 2 corners_b corners_blocker + 1 cuts, so O(m^2) pieces of 34 evaluations, O(corners_b corners_blocker)
//   each.
//   Source: J. H. Lambert, Photometria, 1760; D. R. Baum, H. E. Rushmeier, J. M. Winget, Improving radiosity solutions
//     through the use of analytically determined form-factors, SIGGRAPH 1989; critical lines as in P. Heckbert,
//     Discontinuity meshing for radiosity, Eurographics Workshop on Rendering 1992.
Approximation formFactorPastBlocker(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b,
                                    std::span<const glm::dvec3> blocker);

}  // namespace viewpeel::reference
