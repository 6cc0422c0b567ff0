// Coplanar polygons share one plane, so that their depths along a line are equal to the last bit.
#pragma once
#include <viewpeel/scene.h>

namespace viewpeel {

// Corners within this distance of a larger polygon's plane make a polygon coplanar with it, in unit-ball units. It is a
// hundred times the rounding of coordinates that a rotation in double precision leaves, and about one unit of the
// engines' depth.
constexpr double kCoplanarTolerance = 1e-8;

// The plane of a polygon's own corners, through their mean; its normal is the front's.    Cost: O(1).
Plane planeOf(const Scene& scene, const Polygon& polygon);

// Fills Scene::planes and each polygon's plane and front_along_plane_normal. The largest polygon of a plane defines it.
//   Cost: O(n log n) where few planes are nearly parallel and nearly coincident.
void groupPlanes(Scene& scene);

}  // namespace viewpeel
