#include "scene/exposed_backs.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <glm/glm.hpp>

#include "scene/shells.h"
#include "scene/sight.h"

namespace viewpeel {
namespace {

using glm::dvec3;

struct Box {
  dvec3 low{INFINITY}, high{-INFINITY};

  void widen(const Box& by) { low = glm::min(low, by.low), high = glm::max(high, by.high); }
  dvec3 middle() const { return 0.5 * (low + high); }
  bool operator==(const Box&) const = default;
};

// A Body is what the fronts of a shell enclose, with its opening closed.
struct Body {
  dvec3 apex{0};      // on the shell, and in the plane of its opening
  double volume = 0;  // behind the fronts; what lies before them counts as negative
  double area = 0;
  dvec3 normal{0};  // sum of all fronts' normals, by area
  Box box{};

  // Returns whether all faces lie in the plane of the opening.
  bool isFlat() const { return std::abs(volume) <= 1e-12 * area; }
};

std::vector<Body> findBodies(const Scene& scene, const std::vector<Shell>& shells) {
  const std::vector<uint32_t> shell_of = shellsOfFaces(shells, scene.faces.size());
  std::vector<Body> bodies(shells.size());
  for (const Polygon& polygon : scene.polygons) {
    const uint32_t k = shell_of[polygon.face];
    Body& body = bodies[k];
    const auto corners = std::span(scene.corners).subspan(polygon.first_corner, polygon.corner_count);
    if (body.area == 0) body.apex = shells[k].outer_opening.value_or(corners[0]);
    body.volume += volumeBehind(scene, polygon, body.apex);
    body.area += polygon.area;
    body.normal += polygon.area * frontNormal(scene, polygon);
    for (const dvec3& corner : corners) body.box.widen({corner, corner});
  }
  return bodies;
}

}  // namespace

std::vector<bool> findExposedBacks(const Scene& scene) {
  const std::vector<Shell> shells = findShells(scene);
  const std::vector<Body> bodies = findBodies(scene, shells);
  Box all;
  for (const Body& body : bodies) all.widen(body.box);
  const auto isExposed = [&](const Shell& shell, const Body& body) {
    if (shell.is_twisted || std::ranges::find(shell.is_against, true) != shell.is_against.end()) return true;
    if (!shell.is_closed && !shell.outer_opening) return true;
    if (!shell.is_closed && body.isFlat()) return !(glm::dot(body.normal, all.middle() - body.apex) > 0);
    return body.volume < 0 && body.box != all;  // a room, and not all of the scene is in it
  };
  std::vector<bool> is_exposed(scene.faces.size());
  for (size_t k = 0; k < shells.size(); ++k)
    if (isExposed(shells[k], bodies[k]))
      for (const uint32_t face : shells[k].faces) is_exposed[face] = true;
  return is_exposed;
}

}  // namespace viewpeel
