// Cuts parts that other polygons of its plane cover away from a polygon.
#pragma once
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// Cuts convex polygons out of a convex polygon of the same plane.
//   In: corners: counter-clockwise about `normal`, which has unit length; holes: convex, either way round
//   Out: convex pieces with the same front, of more than 1e-14 of the polygon's area each; none where nothing is left
//   Error: corners to a few ulps of the polygon's size.    Cost: O(pieces x holes).
//   Source: I. E. Sutherland & G. W. Hodgman, Reentrant polygon clipping, Communications of the ACM 17(1), 1974, 32-42.
std::vector<std::vector<glm::dvec3>> cutAway(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal,
                                             const std::vector<std::vector<glm::dvec3>>& holes);

// Returns the normal of a polygon by its corners (Newell), its length twice the area.    Cost: O(corners).
glm::dvec3 twiceAreaNormal(const std::vector<glm::dvec3>& corners);

}  // namespace viewpeel
