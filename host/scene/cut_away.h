// cutAway() removes from a polygon the parts that other polygons of its plane cover.
#pragma once
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// Cuts holes, which are convex polygons, out of a convex polygon of the same plane.
//   In: corners: of the polygon, counter-clockwise about `normal`, a unit vector; holes: convex polygons, whose corners
//     run either way round
//   Out: convex pieces of what the holes leave, with the same front. Pieces below 1e-14 of the polygon are
//   dropped.
//   Error: corners are good to a few ulps of the polygon's size.    Cost: O(pieces x holes).
//   Source: I. E. Sutherland & G. W. Hodgman, Reentrant polygon clipping, Communications of the ACM 17(1), 1974, 32-42.
std::vector<std::vector<glm::dvec3>> cutAway(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal,
                                             const std::vector<std::vector<glm::dvec3>>& holes);

// Returns the normal of a polygon by Newell's formula. Its length is twice the polygon's area.    Cost: O(corners).
glm::dvec3 twiceAreaNormal(const std::vector<glm::dvec3>& corners);

}  // namespace viewpeel
