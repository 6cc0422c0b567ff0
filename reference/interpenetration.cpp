#include <algorithm>
#include <cmath>
#include <optional>

#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>
#include <glm/glm.hpp>

#include "matrix/ids.h"
#include "reference/exact_pair_areas.h"

namespace viewpeel::reference {
namespace {

struct Interval {
  double low, high;
};

// Where the polygon meets the line of its plane with `other`, as parameters along `along` from `origin`; none where it does not pass through
// `other` by more than the tolerance on both sides.
std::optional<Interval> crossing(const Scene& scene, const Polygon& polygon, const Plane& other, const glm::dvec3& along) {
  double below = 0, above = 0;
  Interval interval{INFINITY, -INFINITY};
  const glm::dvec3* corners = &scene.corners[polygon.first_corner];
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const glm::dvec3 &p = corners[k], &q = corners[(k + 1) % polygon.corner_count];
    const double hp = glm::dot(other.normal, p) - other.offset, hq = glm::dot(other.normal, q) - other.offset;
    below = std::min(below, hp);
    above = std::max(above, hp);
    if ((hp < 0) == (hq < 0)) continue;
    const double t = glm::dot(along, p + (q - p) * (hp / (hp - hq)));
    interval = {std::min(interval.low, t), std::max(interval.high, t)};
  }
  if (below > -kInterpenetrationTolerance || above < kInterpenetrationTolerance) return std::nullopt;
  return interval;
}

std::optional<glm::dvec3> findCommonPoint(const Scene& scene, const Polygon& a, const Polygon& b) {
  const Plane &pa = scene.planes[a.plane], &pb = scene.planes[b.plane];
  const glm::dvec3 line = glm::cross(pa.normal, pb.normal);
  const double sine_squared = glm::dot(line, line);
  if (a.plane == b.plane || sine_squared == 0) return std::nullopt;
  const glm::dvec3 along = line / std::sqrt(sine_squared);
  const auto ia = crossing(scene, a, pb, along), ib = crossing(scene, b, pa, along);
  if (!ia || !ib) return std::nullopt;
  const double low = std::max(ia->low, ib->low), high = std::min(ia->high, ib->high);
  if (high - low <= kInterpenetrationTolerance) return std::nullopt;
  const glm::dvec3 on_line = (pa.offset * glm::cross(pb.normal, line) + pb.offset * glm::cross(line, pa.normal)) / sine_squared;
  return on_line + along * ((low + high) / 2);
}

}  // namespace

std::vector<Interpenetration> findInterpenetrations(const Scene& scene) {
  using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const Polygon*>;
  std::vector<Box> boxes;
  for (const Polygon& polygon : scene.polygons) {
    glm::dvec3 low(INFINITY), high(-INFINITY);
    for (uint32_t k = 0; k < polygon.corner_count; ++k) {
      low = glm::min(low, scene.corners[polygon.first_corner + k]);
      high = glm::max(high, scene.corners[polygon.first_corner + k]);
    }
    boxes.emplace_back(CGAL::Bbox_3(low.x, low.y, low.z, high.x, high.y, high.z), &polygon);
  }
  std::vector<Interpenetration> found;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& first, const Box& second) {
    const Polygon *a = std::min(first.handle(), second.handle()), *b = std::max(first.handle(), second.handle());
    if (const auto place = findCommonPoint(scene, *a, *b))
      found.push_back({uint32_t(a - scene.polygons.data()), uint32_t(b - scene.polygons.data()), *place});
  });
  std::sort(found.begin(), found.end(), [](const auto& p, const auto& q) { return std::pair(p.a, p.b) < std::pair(q.a, q.b); });
  return found;
}

std::string describe(const Scene& scene, const Interpenetration& interpenetration) {
  const Ids ids = makeIds(scene, By::polygon, false);
  const glm::dvec3 place = scene.centre + scene.scale * interpenetration.place;
  return fmt::format("{}: polygons {} and {} pass through each other at ({:.6g}, {:.6g}, {:.6g}); cut them there, or move one of them",
                     scene.file, ids.names[ids.of_polygon[interpenetration.a]], ids.names[ids.of_polygon[interpenetration.b]], place.x,
                     place.y, place.z);
}

}  // namespace viewpeel::reference
