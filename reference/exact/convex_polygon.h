// The closed forms work on convex planar polygons in long double, and clip them with these functions.
#pragma once
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel::reference {

using Vec3 = glm::vec<3, long double>;
using ConvexPolygon = std::vector<Vec3>;  // counter-clockwise seen from the front

// A HalfSpace holds the points x with dot(normal, x) >= offset.
struct HalfSpace {
  Vec3 normal{0};  // unit length
  long double offset = 0;

  long double depth(const Vec3& x) const;  // distance of x from the boundary; above 0 inside
};

// A UnitFrame holds two polygons, and perhaps a blocker. They are moved and scaled so that all corners are within
// distance 1 of the origin.
struct UnitFrame {
  std::vector<ConvexPolygon> polygons;
  long double rounding = 0;  // bound on the rounding of a coordinate in the input, in the new unit
};

// Maps all corners x to (x - centre) / scale.
//   In: polygons of 3 or more corners each, convex and planar to rounding, any units.
//   Out: the same polygons within the unit ball, and by how much the input's doubles may be rounded there.
//   Error: 2 ulp of long double.
//   Throws: Error bad_input naming the polygon (fewer than 3 corners, NaN or infinity, no area, not convex, not
//   planar).
//   Cost: O(corners of a polygon squared), for the check of convexity.
//   Source: none.
UnitFrame toUnitFrame(std::initializer_list<std::span<const glm::dvec3>> polygons);

Vec3 areaVector(const ConvexPolygon& polygon);  // front normal times area
long double area(const ConvexPolygon& polygon);
Vec3 meanCorner(const ConvexPolygon& polygon);
HalfSpace frontOf(const ConvexPolygon& polygon);

// Returns the part of a polygon in a half space. Corners within `rounding` of the boundary count as inside, and keep
// their place.
//   In: a convex polygon, possibly empty; rounding >= 0, a length.
//   Out: a convex polygon, empty where fewer than 3 corners are left.
//   Error: 2 ulp of long double times 1 / sin(angle between the planes) in the new corners, plus rounding.
//          tests/unit/convex_polygon_test.cpp.
//   Throws: nothing.
//   Cost: O(corners).
//   Source: I. E. Sutherland & G. W. Hodgman, Reentrant polygon clipping, CACM 17(1), 1974.
ConvexPolygon clip(const ConvexPolygon& polygon, const HalfSpace& half_space, long double rounding);

// FacingParts are the parts of two polygons that see each other's front. Each polygon is clipped to the half space in
// front of the other. Both parts are empty if one polygon lies behind or within the other's plane.
struct FacingParts {
  ConvexPolygon a, b;
};
FacingParts facingParts(const ConvexPolygon& a, const ConvexPolygon& b, long double rounding);

}  // namespace viewpeel::reference
