// Shapes are polygons of a scene in the form that the kernels of unoccluded form factors read.
#pragma once
#include <vector>

#include <glm/vec3.hpp>

#include "unoccluded/shared.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the scene's polygons as the kernels of unoccluded form factors read them, see ShapeData.
//   In: a scene as buildScene makes it.     Out: a shape a polygon, in order.
//   Error: rounding of double.
//   Throws: nothing.     Cost: O(polygons).     Source: none.
std::vector<unoccluded_data::ShapeData> makeShapes(const Scene& scene);

// Returns the middle of the four corners, which is not the middle of the area.
inline glm::dvec3 meanCorner(const unoccluded_data::ShapeData& shape) {
  return 0.25 * ((shape.corners[0] + shape.corners[1]) + (shape.corners[2] + shape.corners[3]));
}

// A shape is here an image of the square -1 <= u, v <= 1: mean corner + u along_u + v along_v + u v along_uv.
struct Stretch {
  glm::dvec3 along_u, along_v, along_uv;
};

inline Stretch stretchOf(const unoccluded_data::ShapeData& shape) {
  const auto& c = shape.corners;
  return {0.25 * ((c[1] - c[0]) + (c[2] - c[3])), 0.25 * ((c[3] - c[0]) + (c[2] - c[1])),
          0.25 * ((c[0] - c[1]) + (c[2] - c[3]))};
}

}  // namespace viewpeel
