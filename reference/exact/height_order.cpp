#include "reference/exact/height_order.h"

#include <cmath>
#include <utility>

#include "facing.h"

namespace viewpeel::reference {
namespace {

mpq_class rational(double x) { return toRational(splitDouble(x)); }

}  // namespace

HeightOrder::HeightOrder(const Projection& projection) : projection_(projection) {
  const glm::dvec3& u = projection.u();
  const int k = projection.axis(), i = (k + 1) % 3, j = (k + 2) % 3;
  for (const Outline& outline : projection.outlines()) {
    const Plane& plane = projection.scene().planes[projection.scene().polygons[outline.polygon].plane];
    const glm::dvec3& n = plane.normal;
    const Ball along = Ball{n.x} * Ball{u.x} + Ball{n.y} * Ball{u.y} + Ball{n.z} * Ball{u.z};
    const Ball scale = along * Ball{u[k]};
    heights_.push_back({Ball{plane.offset} / along, -(Ball{n[i]} / scale), -(Ball{n[j]} / scale)});
  }
}

bool HeightOrder::isBelow(uint32_t a, uint32_t b) {
  const bool swapped = b < a;
  if (swapped) std::swap(a, b);
  const auto [entry, is_new] = orders_.try_emplace(uint64_t{a} << 32 | b, false);
  if (is_new) entry->second = decide(a, b);
  return entry->second != swapped;
}

// Decides which of a < b comes first.
bool HeightOrder::decide(uint32_t a, uint32_t b) const {
  const Outline &first = projection_.outlines()[a], &second = projection_.outlines()[b];
  const Scene& scene = projection_.scene();
  int sign = 0;
  if (scene.polygons[first.polygon].plane != scene.polygons[second.polygon].plane) {
    std::vector<glm::dvec2> points = intersect(a, b);
    if (points.empty()) points.push_back(projection_.vertices()[first.vertices[0]].rounded);
    Ball largest;
    glm::dvec2 place = points[0];
    for (const glm::dvec2& p : points) {
      const Ball difference = heights_[a].at(p) - heights_[b].at(p);
      if (std::abs(difference.value) <= std::abs(largest.value)) continue;
      largest = difference;
      place = p;
    }
    sign = certainSign(largest);
    if (sign == 0) sign = compareHeights(a, b, place);
  }
  if (sign != 0) return sign < 0;
  const auto placeOf = [&](const Outline& outline) {
    return placeAtTie(outline.front_up, scene.polygons[outline.polygon].tie_rank);
  };
  return placeOf(first) <= placeOf(second);
}

int HeightOrder::compareHeights(uint32_t a, uint32_t b, const glm::dvec2& point) const {
  const Scene& scene = projection_.scene();
  const glm::dvec3& u = projection_.u();
  const int k = projection_.axis(), i = (k + 1) % 3, j = (k + 2) % 3;
  const auto height = [&](uint32_t outline) -> mpq_class {
    const Plane& plane = scene.planes[scene.polygons[projection_.outlines()[outline].polygon].plane];
    mpq_class along = 0;
    for (int c = 0; c < 3; ++c) along += rational(plane.normal[c]) * rational(u[c]);
    return (rational(plane.offset) * rational(u[k]) - rational(plane.normal[i]) * rational(point.x) -
            rational(plane.normal[j]) * rational(point.y)) /
           along;
  };
  // height() is the height along u, times u_k.
  return cmp(height(a), height(b)) * (u[k] > 0 ? 1 : -1);
}

// Returns corners of the common part of two outlines (I. Sutherland and G. Hodgman, 1974). New points lie between two
// old ones, and a point counts as inside up to the rounding of `side`. So the result is not empty where the exact
// outlines share a point.
std::vector<glm::dvec2> HeightOrder::intersect(uint32_t a, uint32_t b) const {
  const auto& vertices = projection_.vertices();
  std::vector<glm::dvec2> points, clipped;
  for (const uint32_t v : projection_.outlines()[a].vertices) points.push_back(vertices[v].rounded);
  const std::vector<uint32_t>& frame = projection_.outlines()[b].vertices;
  for (size_t k = 0; k < frame.size() && !points.empty(); ++k) {
    const glm::dvec2 begin = vertices[frame[k]].rounded;
    const glm::dvec2 along = vertices[frame[(k + 1) % frame.size()]].rounded - begin;
    const auto side = [&](const glm::dvec2& p) {
      const glm::dvec2 to_p = p - begin;
      const double rounding = 1e-15 * (std::abs(along.x) + std::abs(along.y) + std::abs(to_p.x) + std::abs(to_p.y));
      return along.x * to_p.y - along.y * to_p.x + rounding;
    };
    clipped.clear();
    for (size_t m = 0; m < points.size(); ++m) {
      const glm::dvec2 &p = points[m], &q = points[(m + 1) % points.size()];
      const double p_side = side(p), q_side = side(q);
      if (p_side >= 0) clipped.push_back(p);
      if ((p_side >= 0) != (q_side >= 0)) clipped.push_back(p + (q - p) * (p_side / (p_side - q_side)));
    }
    points.swap(clipped);
  }
  return points;
}

}  // namespace viewpeel::reference
