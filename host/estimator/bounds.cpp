#include "estimator/bounds.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "scene/perimeter.h"

namespace viewpeel {
namespace {

double diameterOf(const Scene& scene, const Polygon& polygon) {
  double diameter = 0;
  for (uint32_t a = 0; a < polygon.corner_count; ++a)
    for (uint32_t b = 0; b < a; ++b)
      diameter = std::max(
          diameter, glm::length(scene.corners[polygon.first_corner + a] - scene.corners[polygon.first_corner + b]));
  return diameter;
}

}  // namespace

ConvexSize sizeOf(const Scene& scene, const Polygon& polygon) {
  return {polygon.area, perimeterOf(scene, polygon), diameterOf(scene, polygon)};
}

double latticeRange(const ConvexSize& x, double h) { return 2 * x.area + x.perimeter * h + 2 * h * h; }

double scanlineRange(const ConvexSize& x, double h) {
  return 2 * x.area + 2 * h * x.diameter + 0x1p-9 * h * (x.diameter + h);
}

double formFactorRange(double range_i, double range_j, double area_i) { return std::min(range_i, range_j) / area_i; }

}  // namespace viewpeel
