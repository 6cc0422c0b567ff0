#include "scene/sight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

#include "scene/coincident.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr double kStepBack = 2 * kCoincidenceReach / Sight::kLeastCosine;

}  // namespace

Sight::Sight(const Scene& scene) : scene_(scene), tree_(scene) {
  normals_.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) normals_.push_back(frontNormal(scene, polygon));
}

dvec3 Sight::pointOn(uint32_t polygon) {
  const Polygon& p = scene_.polygons[polygon];
  const dvec3* c = &scene_.corners[p.first_corner];
  double u = uniform(), v = uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  uint32_t k = 1;
  if (p.corner_count == 4 && uniform() * p.area > glm::length(glm::cross(c[1] - c[0], c[2] - c[0])) / 2) k = 2;
  return c[0] + u * (c[k] - c[0]) + v * (c[k + 1] - c[0]);
}

dvec3 Sight::pointOn(uint32_t polygon, double u, double v) const {
  const Polygon& p = scene_.polygons[polygon];
  const dvec3* c = &scene_.corners[p.first_corner];
  uint32_t k = 1;
  if (p.corner_count == 4) {
    const double first = glm::length(glm::cross(c[1] - c[0], c[2] - c[0])) / (2 * p.area);  // share of one triangle
    k = u < first ? 1 : 2;
    u = k == 1 ? u / first : (u - first) / (1 - first);
  }
  const double across = std::sqrt(u);  // from c[0] to the opposite side
  return c[0] + across * (c[k] - c[0] + v * (c[k + 1] - c[k]));
}

dvec3 Sight::directionFrom(uint32_t polygon, bool from_front) {
  const double square = kLeastCosine * kLeastCosine + (1 - kLeastCosine * kLeastCosine) * uniform();
  return directionFrom(polygon, from_front, square, uniform());
}

dvec3 Sight::directionFrom(uint32_t polygon, bool from_front, double square_of_height, double turn) const {
  const dvec3 axis = from_front ? normals_[polygon] : -normals_[polygon];
  const dvec3 across = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double height = std::sqrt(square_of_height);
  const double angle = 2 * std::numbers::pi * turn, radius = std::sqrt(1 - height * height);
  return height * axis + radius * (std::cos(angle) * across + std::sin(angle) * glm::cross(axis, across));
}

Sight::End Sight::look(uint32_t polygon, const dvec3& point, const dvec3& direction) const {
  const Polygon& from = scene_.polygons[polygon];
  const auto isAhead = [&](uint32_t a, uint32_t b) {  // for two polygons of one plane: whether a ray meets b first
    const int step = levelOf(scene_.polygons[a]) - levelOf(scene_.polygons[b]);
    const bool along = glm::dot(direction, scene_.planes[from.plane].normal) > 0;
    return step != 0 ? (step > 0) == along : a > b;
  };
  const PolygonTree::Hit* first = nullptr;
  const std::vector<PolygonTree::Hit> hits = tree_.cast(point - kStepBack * direction, direction, 0);
  for (const PolygonTree::Hit& hit : hits) {
    if (hit.polygon == polygon) continue;
    const uint32_t plane = scene_.polygons[hit.polygon].plane;
    if (plane == from.plane ? !isAhead(hit.polygon, polygon) : hit.distance <= kStepBack) continue;
    if (!first) {
      first = &hit;
      continue;
    }
    if (hit.distance > first->distance + kCoincidenceReach) break;  // hits are sorted by distance
    const Polygon &p = scene_.polygons[hit.polygon], &q = scene_.polygons[first->polygon];
    const bool along = glm::dot(direction, scene_.planes[p.plane].normal) > 0;
    if (p.plane == q.plane && levelOf(p) != levelOf(q) && (levelOf(p) < levelOf(q)) == along) first = &hit;
  }
  return first ? End{first->polygon, first->is_front} : End{};
}

std::vector<double> sumAreas(const Scene& scene, const std::vector<uint32_t>& polygons) {
  std::vector<double> sums;
  for (const uint32_t polygon : polygons)
    sums.push_back((sums.empty() ? 0 : sums.back()) + scene.polygons[polygon].area);
  return sums;
}

uint32_t pickBySums(const std::vector<double>& sums, double at) {
  const auto found = std::upper_bound(sums.begin(), sums.end(), at);
  return static_cast<uint32_t>(std::min<ptrdiff_t>(found - sums.begin(), static_cast<ptrdiff_t>(sums.size()) - 1));
}

}  // namespace viewpeel
