#include "reference/exact/convex_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <glm/geometric.hpp>

#include <viewpeel/error.h>

namespace viewpeel::reference {
namespace {

// Corners further out of the plane, or turning back by more, than this share of the polygon's size are an error of the
// caller. The share is far above the rounding of doubles and far below the effect of a wrong corner.
constexpr long double kShapeTolerance = 1e-9L;

[[noreturn]] void refuse(size_t index, const char* what) {
  throw Error(ErrorCode::bad_input, "polygon " + std::to_string(index) + " of the call " + what);
}

void checkShape(const ConvexPolygon& polygon, long double rounding, size_t index) {
  const Vec3 normal = areaVector(polygon);
  const long double twice_area = 2 * glm::length(normal);
  long double size = 0;
  for (const Vec3& corner : polygon) size = std::max(size, glm::length(corner - polygon[0]));
  if (!(twice_area > std::numeric_limits<double>::epsilon() * size * size)) refuse(index, "has no area; drop it");
  const HalfSpace front = frontOf(polygon);
  const long double tolerance = std::max(kShapeTolerance * size, 4 * rounding);
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    if (std::abs(front.depth(p)) > tolerance) refuse(index, "is not planar; split it into triangles");
    const Vec3 inward = glm::cross(front.normal, q - p);
    for (const Vec3& corner : polygon)
      if (glm::dot(inward, corner - p) < -tolerance * size) refuse(index, "is not convex; split it");
  }
}

}  // namespace

long double HalfSpace::depth(const Vec3& x) const { return glm::dot(normal, x) - offset; }

UnitFrame toUnitFrame(std::initializer_list<std::span<const glm::dvec3>> polygons) {
  Vec3 low(std::numeric_limits<long double>::infinity()), high = -low;
  long double largest = 0;
  size_t index = 0;
  for (const auto& polygon : polygons) {
    if (polygon.size() < 3) refuse(index, "has fewer than 3 corners; drop it");
    for (const glm::dvec3& corner : polygon)
      for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(corner[axis])) refuse(index, "has a corner that is not finite");
        low[axis] = std::min(low[axis], (long double)corner[axis]);
        high[axis] = std::max(high[axis], (long double)corner[axis]);
        largest = std::max(largest, std::abs((long double)corner[axis]));
      }
    ++index;
  }
  const Vec3 centre = (low + high) / 2.0L;
  const long double scale = glm::length(high - low) / 2;
  if (!(scale > 0)) refuse(0, "has no area; drop it");
  UnitFrame frame;
  frame.rounding = 4 * std::numeric_limits<double>::epsilon() * (largest / scale);
  for (const auto& polygon : polygons) {
    ConvexPolygon& moved = frame.polygons.emplace_back();
    for (const glm::dvec3& corner : polygon) moved.push_back((Vec3(corner) - centre) / scale);
    checkShape(moved, frame.rounding, frame.polygons.size() - 1);
  }
  return frame;
}

Vec3 areaVector(const ConvexPolygon& polygon) {
  Vec3 sum(0);
  for (size_t k = 2; k < polygon.size(); ++k) sum += glm::cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
  return sum / 2.0L;
}

long double area(const ConvexPolygon& polygon) { return glm::length(areaVector(polygon)); }

Vec3 meanCorner(const ConvexPolygon& polygon) {
  Vec3 sum(0);
  for (const Vec3& corner : polygon) sum += corner;
  return sum / (long double)polygon.size();
}

HalfSpace frontOf(const ConvexPolygon& polygon) {
  const Vec3 normal = glm::normalize(areaVector(polygon));
  return {normal, glm::dot(normal, meanCorner(polygon))};
}

ConvexPolygon clip(const ConvexPolygon& polygon, const HalfSpace& half_space, long double rounding) {
  ConvexPolygon kept;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const long double p_depth = half_space.depth(p), q_depth = half_space.depth(q);
    if (p_depth >= -rounding) kept.push_back(p);
    const bool crosses = (p_depth > rounding && q_depth < -rounding) || (p_depth < -rounding && q_depth > rounding);
    if (crosses) kept.push_back(p + (q - p) * (p_depth / (p_depth - q_depth)));
  }
  if (kept.size() < 3) kept.clear();
  return kept;
}

FacingParts facingParts(const ConvexPolygon& a, const ConvexPolygon& b, long double rounding) {
  const HalfSpace front_a = frontOf(a), front_b = frontOf(b);
  const auto reachesInto = [rounding](const ConvexPolygon& polygon, const HalfSpace& front) {
    return std::any_of(polygon.begin(), polygon.end(), [&](const Vec3& x) { return front.depth(x) > rounding; });
  };
  if (!reachesInto(a, front_b) || !reachesInto(b, front_a)) return {};
  FacingParts parts{clip(a, front_b, rounding), clip(b, front_a, rounding)};
  if (parts.a.empty() || parts.b.empty()) return {};
  return parts;
}

}  // namespace viewpeel::reference
