// Form factors in closed form, or to near the last digit by quadrature: what tests and checks lean on. All are dimensionless; lengths may be in any
// one unit. A polygon's front is the side from which its corners run counter-clockwise.
#pragma once
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel::reference {

using Loop = std::vector<glm::dvec3>;

// A rectangle with sides along the coordinate axes.
struct Span {
  double low, high;
};

// From the rectangle x1 x y1 at z = 0 to the rectangle x2 x y2 at height z > 0, facing each other.
//   Error: the sum of 16 terms cancels: absolute error about 1e-15 (D / d)^4 for rectangles of sides down to d at distances up to D.
//   Source: Ehlert & Smith, J. Thermophysics and Heat Transfer 7(1), 1993, 173-175; Howell C-13.
double parallelRectangles(Span x1, Span y1, Span x2, Span y2, double z);

// From the rectangle x1 x y in the plane z = 0 to the rectangle x2 x z in the plane y = 0, with y, z >= 0; a common edge is allowed.
//   Error: as above.    Source: Ehlert & Smith 1993; Howell C-15.
double perpendicularRectangles(Span x1, Span y, Span x2, Span z);

// From a disc of radius r1 to a coaxial parallel one of radius r2 at distance h > 0.
//   Error: a few ulp of 1.    Source: Howell C-41; Siegel & Howell, Thermal Radiation Heat Transfer.
double coaxialDiscs(double r1, double r2, double h);

// From convex polygon a to convex polygon b, nothing between them; each is first clipped to the front half space of the other.
//   F = 1 / (2 pi A_a) sum over edge pairs of (e_a . e_b) times the double integral of ln r: the inner one in closed form, the outer by adaptive
//   quadrature with ends graded towards where r vanishes.
//   Error: below 1e-10 absolute, common edges and corners included; tests/closed_forms_test.cpp.
//   Cost: edge pairs x about 100 to 2000 evaluations.
//   Source: Sparrow 1963 (contour integrals); Schroeder & Hanrahan 1993 for what the fully closed form takes.
double polygonToPolygon(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

// From the point at `p` with unit normal n to a polygon, clipped to the front half space of n and seen from its front (Lambert 1760).
//   Error: a few ulp of 1.
double pointToPolygon(const glm::dvec3& p, const glm::dvec3& n, std::span<const glm::dvec3> polygon);

// From convex polygon a to convex polygon b past the convex polygon `blocker`, which blocks on both sides and lies in front of a.
//   The mean over a of pointToPolygon of b less the shadow that the blocker casts on it, by adaptive quadrature on triangles.
//   Error: below `tolerance` absolute, estimated by the difference between two levels of subdivision.
double polygonPastBlocker(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b, std::span<const glm::dvec3> blocker,
                          double tolerance = 1e-7);

// The paper's ff(A, B): the mean of 2 area(intersection of the projections) / A_a over iid directions, with exact intersection areas.
struct Estimated {
  double value, standard_error;
};
//   In: convex polygons with nothing between them; direction_count >= 2
//   Error: standard error as given, O(1 / sqrt(direction_count)).    Source: Pellegrini 1997, section 4.1.
Estimated estimateByProjection(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b, uint64_t direction_count, uint64_t seed);

double areaOf(std::span<const glm::dvec3> polygon);

// The part of a convex polygon where dot(normal, x) >= offset.
Loop clip(std::span<const glm::dvec3> polygon, const glm::dvec3& normal, double offset);

}  // namespace viewpeel::reference
