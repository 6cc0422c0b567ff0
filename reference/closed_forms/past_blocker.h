// formFactorPastBlocker() integrates the form factor of two convex polygons of which a third one blocks the view.
#pragma once
#include <span>

#include <glm/vec3.hpp>

#include "reference/closed_forms/quadrature.h"

namespace viewpeel::reference {

constexpr double kPastBlockerError = 1e-7;

// Returns F from polygon a to polygon b, fronts only, with one blocker that stops light on both of its sides:
//   F = 1/A int_a (f(x, b) - f(x, b within the blocker's shadow from x)) dx,
//   2 pi f(x, polygon) = - sum_k angle(r_k, r_k+1) n . (r_k x r_k+1) / |r_k x r_k+1|,   r_k = corner_k - x (Lambert).
// First a is cut along every line from which a corner of b and an edge of the blocker are seen in one place. It is cut
// likewise for corners of the blocker and edges of b, and along the blocker's plane. On each piece the integrand is
// analytic. Below an edge close to a, the integrand changes over a distance of the edge's height. So a is cut there
// into strips of growing width. The pieces are cut into triangles, and the triangle of largest error is halved again
// and again.
//   In: three convex planar polygons of 3 or more corners, in one unit; a and b counter-clockwise seen from the front.
//     The blocker may touch or cross a or b. The part of the blocker behind the plane of a or b blocks nothing, and
//     neither does a blocker within the plane of a. A blocker within the plane of b covers b.
//   Out: F from a to b, without unit. Its `error` is the sum of |5 x 5-point - 3 x 3-point rule| over the triangles,
//     and the area that cuts have lost.
//   Error: at most `error`, which is below kPastBlockerError, because the difference of the rules estimates the error
//     of the worse one. This holds for gaps down to 1e-12 of the size. Tests: tests/unit/past_blocker_test.cpp.
//   Throws: Error bad_input (a degenerate polygon); Error limit (kPastBlockerError not reached in 200,000 triangles).
//   Cost: m = 2 corners_b corners_blocker + 1 cuts, so O(m^2) pieces of 34 evaluations, O(corners_b corners_blocker)
//   each.
//   Source: J. H. Lambert, Photometria, 1760; D. R. Baum, H. E. Rushmeier, J. M. Winget, Improving radiosity solutions
//     through the use of analytically determined form-factors, SIGGRAPH 1989; critical lines as in P. Heckbert,
//     Discontinuity meshing for radiosity, Eurographics Workshop on Rendering 1992.
Approximation formFactorPastBlocker(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b,
                                    std::span<const glm::dvec3> blocker);

}  // namespace viewpeel::reference
