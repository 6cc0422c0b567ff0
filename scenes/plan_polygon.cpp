#include "scenes/plan_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/glm.hpp>

namespace viewpeel::bench {
namespace {

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

glm::dvec2 before(const PlanPolygon& polygon, size_t k) { return polygon[(k + polygon.size() - 1) % polygon.size()]; }
glm::dvec2 after(const PlanPolygon& polygon, size_t k) { return polygon[(k + 1) % polygon.size()]; }

PlanPolygon replaceCorner(const PlanPolygon& polygon, size_t k, const PlanPolygon& by) {
  PlanPolygon result(polygon.begin(), polygon.begin() + static_cast<std::ptrdiff_t>(k));
  result.insert(result.end(), by.begin(), by.end());
  result.insert(result.end(), polygon.begin() + static_cast<std::ptrdiff_t>(k) + 1, polygon.end());
  return result;
}

}  // namespace

double areaOf(const PlanPolygon& polygon) {
  double twice = 0;
  for (size_t k = 0; k < polygon.size(); ++k) twice += cross(polygon[k] - polygon[0], after(polygon, k) - polygon[0]);
  return twice / 2;
}

bool contains(const PlanPolygon& polygon, glm::dvec2 p) {
  bool inside = false;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec2 a = polygon[k], b = after(polygon, k);
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

double distanceTo(const PlanPolygon& polygon, glm::dvec2 p) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec2 a = polygon[k], side = after(polygon, k) - a;
    const double t = std::clamp(glm::dot(p - a, side) / glm::dot(side, side), 0.0, 1.0);
    least = std::min(least, glm::distance(p, a + t * side));
  }
  return least;
}

glm::dvec2 meanOf(const PlanPolygon& polygon) {
  glm::dvec2 sum(0);
  for (const glm::dvec2 p : polygon) sum += p;
  return sum / double(polygon.size());
}

PlanPolygon inset(const PlanPolygon& polygon, double distance) {
  PlanPolygon result;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec2 in = glm::normalize(polygon[k] - before(polygon, k)),
                     out = glm::normalize(after(polygon, k) - polygon[k]);
    // The corner moves by v with cross(in, v) = cross(out, v) = distance.
    result.push_back(polygon[k] + distance * (out - in) / cross(in, out));
  }
  return result;
}

PlanPolygon rectangle(glm::dvec2 centre, glm::dvec2 half_size, double turned_rad) {
  const glm::dvec2 x(std::cos(turned_rad), std::sin(turned_rad)), y(-x.y, x.x);
  const glm::dvec2 a = half_size.x * x, b = half_size.y * y;
  return {centre - a - b, centre + a - b, centre + a + b, centre - a + b};
}

PlanPolygon cutCorner(const PlanPolygon& polygon, size_t k, double a, double b) {
  const glm::dvec2 corner = polygon[k];
  return replaceCorner(polygon, k,
                       {corner + a * (before(polygon, k) - corner), corner + b * (after(polygon, k) - corner)});
}

PlanPolygon notchCorner(const PlanPolygon& polygon, size_t k, double a, double b) {
  const glm::dvec2 corner = polygon[k], u = a * (before(polygon, k) - corner), v = b * (after(polygon, k) - corner);
  return replaceCorner(polygon, k, {corner + u, corner + u + v, corner + v});
}

PlanPolygon roundCorners(const PlanPolygon& polygon, uint32_t sides, double length) {
  PlanPolygon result;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec2 in = glm::normalize(polygon[k] - before(polygon, k)),
                     out = glm::normalize(after(polygon, k) - polygon[k]);
    const double turn_rad = std::atan2(cross(in, out), glm::dot(in, out)), half_rad = turn_rad / (2 * sides);
    const double radius = length / (2 * std::sin(half_rad));  // of the arc; the new sides are its chords
    const glm::dvec2 centre = polygon[k] - radius * std::tan(turn_rad / 2) * in + radius * glm::dvec2(-in.y, in.x);
    for (uint32_t s = 0; s <= sides; ++s) {
      const double angle_rad = 2 * half_rad * s;
      const glm::dvec2 spoke(in.y, -in.x);
      result.push_back(centre + radius * (std::cos(angle_rad) * spoke + std::sin(angle_rad) * in));
    }
  }
  return result;
}

}  // namespace viewpeel::bench
