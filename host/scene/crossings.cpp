#include "scene/crossings.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "scene/polygon_tree.h"

namespace viewpeel {
namespace {

// The interval that a polygon cuts from a line in a plane, along the line.
struct Chord {
  bool exists = false;
  double begin = 0, end = 0;
};

// Where the polygon cuts the plane, if it has corners far enough on both sides of it.    In: along: of the line
Chord cutByPlane(const Scene& scene, const Polygon& polygon, const Plane& plane, const glm::dvec3& along) {
  const glm::dvec3* corners = &scene.corners[polygon.first_corner];
  const auto heightOf = [&](uint32_t k) { return glm::dot(plane.normal, corners[k]) - plane.offset; };
  double lowest = 0, highest = 0;
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    lowest = std::min(lowest, heightOf(k));
    highest = std::max(highest, heightOf(k));
  }
  Chord chord;
  if (lowest >= -kCrossingDepth || highest <= kCrossingDepth) return chord;
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const uint32_t next = (k + 1) % polygon.corner_count;
    const double here = heightOf(k), there = heightOf(next);
    if ((here < 0) == (there < 0)) continue;
    const double at = glm::dot(along, corners[k] + here / (here - there) * (corners[next] - corners[k]));
    chord = chord.exists ? Chord{true, std::min(chord.begin, at), std::max(chord.end, at)} : Chord{true, at, at};
  }
  return chord;
}

bool areCrossing(const Scene& scene, const Polygon& a, const Polygon& b) {
  if (a.plane == b.plane || a.face == b.face) return false;
  const glm::dvec3 line = glm::cross(scene.planes[a.plane].normal, scene.planes[b.plane].normal);
  if (!(glm::length(line) > 0)) return false;
  const glm::dvec3 along = glm::normalize(line);
  const Chord of_a = cutByPlane(scene, a, scene.planes[b.plane], along);
  if (!of_a.exists) return false;
  const Chord of_b = cutByPlane(scene, b, scene.planes[a.plane], along);
  return of_b.exists && std::min(of_a.end, of_b.end) - std::max(of_a.begin, of_b.begin) > kCrossingDepth;
}

}  // namespace

std::optional<std::pair<uint32_t, uint32_t>> findCrossing(const Scene& scene) {
  const PolygonTree tree(scene);
  std::optional<std::pair<uint32_t, uint32_t>> found;
  for (uint32_t a = 0; a < scene.polygons.size() && !found; ++a)
    tree.forEachNear(a, 0, [&](uint32_t b) {
      if (!found && b > a && areCrossing(scene, scene.polygons[a], scene.polygons[b])) found = {a, b};
    });
  return found;
}

}  // namespace viewpeel
