// formFactor() computes the form factor of two convex polygons with nothing between them, by contour integrals.
#pragma once
#include <span>

#include <glm/vec3.hpp>

namespace viewpeel::reference {

constexpr double kContourError = 1e-11;      // absolute error of every form factor
constexpr double kFarRelativeError = 1e-10;  // relative error for pairs farther apart than kFarDistance
constexpr double kFarDistance = 4;           // distance of the mean corners over the sum of the radii about them

// Returns F from polygon a to polygon b, fronts only:
//   F = 1/(2 pi A) oint_a oint_b ln r ds . dt.
// The sum is over pairs of edges. The inner integral has a closed form. The outer one is adaptive, and cut where the
// inner one is nearly singular. A far pair's logarithms cancel, so there F = 1/A int_a int_b cos cos / (pi r^2) by
// product Gauss rules.
// A polygon that reaches behind the other's plane is clipped to its front first; A stays the whole a's area.
//   In: convex planar polygons of 3 or more corners, counter-clockwise seen from the front, any unit; interiors
//     disjoint. They may share an edge, a corner, a part of an edge, or all but touch.
//   Out: F from a to b, 1; 0 where one lies behind, or within rounding of, the other's plane.
//   Error: kContourError absolute; for pairs farther apart than kFarDistance also kFarRelativeError relative. Two rules
//     are compared, and their difference estimates the error of the worse one. The corners are taken as exact: the
//     effect of their rounding on F comes on top. Tests: tests/unit/contour_integral_test.cpp.
//   Throws: Error bad_input (a polygon is degenerate, not convex or not planar); Error limit where the estimated error
//     is above these bounds (move the polygon, or split the other one). A square of 1e-7 times the size of
//     the scene is such a case, or a sliver 1e-8 wide.
//   Cost: O(corners_a corners_b) outer integrals, with 26 logarithms for each interval. A nearly singular integral
//     takes about 40 intervals.
//   Source: E. M. Sparrow, A new and simpler formulation for radiative angle factors, J. Heat Transfer 85(2), 1963,
//     81-87; J. R. Howell, R. Siegel, M. P. Menguc, Thermal Radiation Heat Transfer, on contour integration.
double formFactor(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

}  // namespace viewpeel::reference
