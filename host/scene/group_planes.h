// groupPlanes() lets coplanar polygons share one plane, so that their depths along a line are equal to the last bit.
#pragma once
#include <viewpeel/scene.h>

namespace viewpeel {

// A polygon is coplanar with a larger one if its corners are within this distance of the larger polygon's plane, in
// unit-ball units. The distance is a hundred times the rounding that a rotation in double precision leaves, and about
// one unit of the engines' depth.
constexpr double kCoplanarTolerance = 1e-8;

// Returns the plane through the mean of a polygon's own corners, with the normal of its front.    Cost: O(1).
Plane planeOf(const Scene& scene, const Polygon& polygon);

// Sets Scene::planes, and each polygon's `plane` and `front_along_plane_normal`. The largest polygon of a plane defines
// the plane.
//   Cost: O(n log n) where few planes are nearly parallel and nearly coincident.
void groupPlanes(Scene& scene);

}  // namespace viewpeel
