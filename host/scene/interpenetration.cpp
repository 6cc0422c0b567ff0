#include "scene/interpenetration.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <viewpeel/error.h>
#include "scene/group_planes.h"
#include "scene/polygon_tree.h"

namespace viewpeel {
namespace {

struct Chord {
  bool exists = false;
  glm::dvec3 begin{0}, end{0};
};

const glm::dvec3& corner(const Scene& scene, const Polygon& polygon, uint32_t k) {
  return scene.corners[polygon.first_corner + k % polygon.corner_count];
}

// Returns the chord that a plane cuts from a polygon; an empty chord unless the polygon has corners farther than
// `depth` on both sides of the plane.
Chord cutByPlane(const Scene& scene, const Polygon& polygon, const Plane& plane, double depth) {
  double lowest = 0, highest = 0;
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const double height = glm::dot(plane.normal, corner(scene, polygon, k)) - plane.offset;
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  Chord chord;
  if (lowest >= -depth || highest <= depth) return chord;
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const glm::dvec3 &p = corner(scene, polygon, k), &q = corner(scene, polygon, k + 1);
    const double p_height = glm::dot(plane.normal, p) - plane.offset;
    const double q_height = glm::dot(plane.normal, q) - plane.offset;
    if ((p_height < 0) == (q_height < 0)) continue;
    const glm::dvec3 cut = p + (q - p) * (p_height / (p_height - q_height));
    (p_height < 0 ? chord.begin : chord.end) = cut;
    chord.exists = true;
  }
  return chord;
}

}  // namespace

std::vector<Interpenetration> findInterpenetrations(const Scene& scene, double touching_depth) {
  // The planes here come from each polygon's own corners. A shared plane (Scene::planes) may be off by
  // kCoplanarTolerance, and neighbours that touch would then seem to pass through each other.
  std::vector<Plane> planes;
  planes.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) planes.push_back(planeOf(scene, polygon));
  std::vector<Interpenetration> found;
  const auto test = [&](uint32_t a, uint32_t b) {
    const Polygon &polygon_a = scene.polygons[a], &polygon_b = scene.polygons[b];
    if (polygon_a.plane == polygon_b.plane) return;
    const Plane &plane_a = planes[a], &plane_b = planes[b];
    const Chord of_a = cutByPlane(scene, polygon_a, plane_b, touching_depth);
    if (!of_a.exists) return;
    const Chord of_b = cutByPlane(scene, polygon_b, plane_a, touching_depth);
    if (!of_b.exists) return;
    // Both chords lie on the line where the two planes meet.
    const glm::dvec3 along = glm::normalize(glm::cross(plane_a.normal, plane_b.normal));
    const auto [a_begin, a_end] = std::minmax({glm::dot(along, of_a.begin), glm::dot(along, of_a.end)});
    const auto [b_begin, b_end] = std::minmax({glm::dot(along, of_b.begin), glm::dot(along, of_b.end)});
    const double begin = std::max(a_begin, b_begin), end = std::min(a_end, b_end);
    if (end - begin <= touching_depth) return;
    const glm::dvec3 middle = of_a.begin + along * ((begin + end) / 2 - glm::dot(along, of_a.begin));
    found.push_back({a, b, scene.centre + scene.scale * middle, end - begin});
  };
  const PolygonTree tree(scene);
  for (uint32_t a = 0; a < scene.polygons.size(); ++a)
    tree.forEachNear(a, 0, [&](uint32_t b) {
      if (a < b) test(a, b);
    });
  std::sort(found.begin(), found.end(), [](const Interpenetration& p, const Interpenetration& q) {
    return std::pair(p.a, p.b) < std::pair(q.a, q.b);
  });
  return found;
}

std::string describe(const Scene& scene, const Interpenetration& found) {
  return fmt::format("{}: {} and {} pass through each other at ({:.6g}, {:.6g}, {:.6g})", scene.file,
                     faceName(scene, scene.polygons[found.a].face), faceName(scene, scene.polygons[found.b].face),
                     found.place.x, found.place.y, found.place.z);
}

void requireDisjoint(const Scene& scene, double touching_depth) {
  const std::vector<Interpenetration> found = findInterpenetrations(scene, touching_depth);
  if (found.empty()) return;
  std::string message = describe(scene, found.front());
  if (found.size() > 1) message += fmt::format(", and {} more pairs", found.size() - 1);
  throw Error(ErrorCode::bad_input, message + "; split them where they meet");
}

}  // namespace viewpeel
