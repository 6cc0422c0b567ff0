// bridgeHoles() makes a simple loop of a face with holes, for splitFace().
#pragma once
#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

namespace viewpeel {

// A BridgedFace is one loop of corners. It runs along each bridge twice, once each way.
struct BridgedFace {
  std::vector<glm::dvec3> corners;
  size_t holes_outside = 0;  // holes that do not lie within the face, and are left out
};

// Joins the holes of a face to its outer ring. A hole is joined where one of its corners touches the loop. Where none
// does, a bridge goes from the hole's corner that is farthest along one axis of the face's plane to a corner that this
// one sees.
//   In: rings: first the outer one, counter-clockwise seen from the front, whose vector area is not zero; then holes,
//     either way round; holes without an area do not count; rings may touch at a point
//   Error: none; corners stay as they are, without repeated ones.    Cost: O(corners^2).
//   Source: D. Eberly, Triangulation by ear clipping, Geometric Tools 1998, section 5.
BridgedFace bridgeHoles(const std::vector<std::vector<glm::dvec3>>& rings);

}  // namespace viewpeel
