// A shape is a polygon of a scene in the form that the kernels of unoccluded form factors read, see ShapeData in
// shaders/unoccluded/unoccluded.h.
#pragma once
#include <vector>

#include <glm/vec3.hpp>

#include "unoccluded/shared.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the shapes of a scene's polygons.
//   In: scene: as buildScene makes it     Out: ShapeData[polygons], in the order of Scene::polygons
//   Error: rounding of double precision.
//   Throws: nothing.     Cost: O(polygons).     Source: none.
std::vector<unoccluded_data::ShapeData> makeShapes(const Scene& scene);

// Fills in what follows from a shape's corners and its normal: area, density, skew, reach, radius and tilt.
void measureShape(unoccluded_data::ShapeData& shape);

// Returns the mean of the four corners, which need not be the centroid.
inline glm::dvec3 meanCorner(const unoccluded_data::ShapeData& shape) {
  return 0.25 * ((shape.corners[0] + shape.corners[1]) + (shape.corners[2] + shape.corners[3]));
}

// A Stretch has the coefficients of a shape as an image of the square -1 <= u, v <= 1: its points are
// mean corner + u along_u + v along_v + u v along_uv.
struct Stretch {
  glm::dvec3 along_u, along_v, along_uv;
};

inline Stretch stretchOf(const unoccluded_data::ShapeData& shape) {
  const auto& c = shape.corners;
  return {0.25 * ((c[1] - c[0]) + (c[2] - c[3])), 0.25 * ((c[3] - c[0]) + (c[2] - c[1])),
          0.25 * ((c[0] - c[1]) + (c[2] - c[3]))};
}

}  // namespace viewpeel
