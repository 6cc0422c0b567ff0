// This header has the form factor of two convex polygons with nothing between them.
#pragma once
#include <span>

#include <glm/vec3.hpp>

namespace viewpeel::reference {

constexpr double kContourError = 1e-11;      // absolute, of every form factor
constexpr double kFarRelativeError = 1e-10;  // of pairs further apart than kFarDistance
constexpr double kFarDistance = 4;           // distance of the mean corners / sum of the radii about them

// Returns F from polygon a to polygon b, fronts only:
//   F = 1/(2 pi A) oint_a oint_b ln r ds . dt,
// summed over pairs of edges: the inner integral in closed form, the outer adaptive, cut where the inner one is nearly
// singular. A far pair's logarithms cancel, so there F = 1/A int_a int_b cos cos / (pi r^2) by product Gauss rules.
// A polygon that reaches behind the other's plane is clipped to its front first; A stays the whole a's area.
//   In: convex planar polygons of 3 or more corners, counter-clockwise seen from the front, any unit; interiors
//   disjoint.
//       They may share an edge, a corner, a part of an edge, or all but touch.
//   Out: F from a to b, 1; 0 where one lies behind, or within rounding of, the other's plane.
//   Error: kContourError absolute; also kFarRelativeError relative for pairs further apart than kFarDistance. Both by
//   the
//          rules' own estimates, which bound the error of the worse of two rules. The corners are taken as exact: what
//          their rounding does to F comes on top. tests/unit/contour_integral_test.cpp.
//   Throws: Error bad_input (a polygon is degenerate, not convex or not planar); Error limit (the estimated error is
//   above
//           the bounds, as for a square 1e-7 times the size of the scene, or a sliver 1e-8 wide: move it, split the
//           other).
//   Cost: O(corners_a corners_b) outer integrals of 26 logarithms per interval; near-singular ones take about 40
//   intervals.
//   Source: E. M. Sparrow, A new and simpler formulation for radiative angle factors, J. Heat Transfer 85(2), 1963,
//     81-87; J. R. Howell, R. Siegel, M. P. Menguc, Thermal Radiation Heat Transfer, on contour integration.
double formFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

}  // namespace viewpeel::reference
