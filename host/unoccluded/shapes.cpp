#include "unoccluded/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace viewpeel {
namespace {

using unoccluded_data::ShapeData;

// Returns the largest |slope| / value that the density has at the middle of an edge of the square, at most 1.
//   In: density: its values at the square's corners
double skewOf(const std::array<double, 4>& density) {
  double skew = 0;
  for (size_t k = 0; k < 4; ++k) {
    const double difference = std::abs(density[k] - density[(k + 1) % 4]), sum = density[k] + density[(k + 1) % 4];
    if (sum > 0) skew = std::max(skew, difference / sum);
  }
  return std::min(skew, 1.0);
}

ShapeData makeShape(const Scene& scene, const Polygon& polygon) {
  ShapeData shape{};
  for (uint32_t k = 0; k < 4; ++k)
    shape.corners[k] = scene.corners[polygon.first_corner + std::min(k, polygon.corner_count - 1)];
  const auto& c = shape.corners;
  shape.normal = glm::normalize(glm::cross(c[2] - c[0], c[3] - c[1]));
  measureShape(shape);
  shape.tie_rank = polygon.tie_rank;
  shape.plane = 2 * polygon.plane + (polygon.front_along_plane_normal ? 0 : 1);
  return shape;
}

}  // namespace

void measureShape(ShapeData& shape) {
  const auto& c = shape.corners;
  const glm::dvec3 mean = meanCorner(shape);
  const auto [along_u, along_v, along_uv] = stretchOf(shape);
  shape.area = glm::dot(shape.normal, glm::cross(c[2] - c[0], c[3] - c[1])) / 2;
  shape.reach = shape.radius = 0;
  shape.density = glm::dot(shape.normal, glm::cross(along_u, along_v));
  shape.density_u = glm::dot(shape.normal, glm::cross(along_u, along_uv));
  shape.density_v = glm::dot(shape.normal, glm::cross(along_uv, along_v));
  // A triangle's last edge is collapsed, so the density there must be 0. A remainder from rounding is set to 0.
  std::array<double, 4> density{};
  for (size_t k = 0; k < 4; ++k) {
    const double u = k == 1 || k == 2 ? 1 : -1, v = k >= 2 ? 1 : -1;
    density[k] = shape.density + shape.density_u * u + shape.density_v * v;
    if (density[k] < 1e-12 * shape.density) density[k] = 0;
  }
  shape.skew = skewOf(density);
  for (const double sign : {-1.0, 1.0})
    shape.reach =
        std::max({shape.reach, glm::length(along_u + sign * along_uv), glm::length(along_v + sign * along_uv)});
  for (const glm::dvec3& corner : c) shape.radius = std::max(shape.radius, glm::length(corner - mean));
  // Area / diameter is the least width, to a factor of 2. Each coordinate of a corner is rounded by at most 2^-53.
  shape.tilt = 4 * std::numeric_limits<double>::epsilon() * shape.radius / shape.area;
}

std::vector<ShapeData> makeShapes(const Scene& scene) {
  std::vector<ShapeData> shapes;
  shapes.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) shapes.push_back(makeShape(scene, polygon));
  return shapes;
}

}  // namespace viewpeel
