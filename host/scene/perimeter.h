// perimeterOf() measures the perimeter of a polygon.
#pragma once
#include <span>

#include <glm/geometric.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the sum over k of |corners[(k + 1) % n] - corners[k]|, added up in this order. It has the unit of the
// corners.
inline double perimeterOf(std::span<const glm::dvec3> corners) {
  double perimeter = 0;
  for (size_t k = 0; k < corners.size(); ++k) perimeter += glm::length(corners[(k + 1) % corners.size()] - corners[k]);
  return perimeter;
}

// Returns the perimeter of a polygon of the scene, unit-ball units.
inline double perimeterOf(const Scene& scene, const Polygon& polygon) {
  return perimeterOf(std::span(scene.corners).subspan(polygon.first_corner, polygon.corner_count));
}

}  // namespace viewpeel
