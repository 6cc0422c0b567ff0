#include "rays/emitter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/glm.hpp>

#include "scene/coincident.h"
#include "scene/polygon_tree.h"

namespace viewpeel {
namespace {

using glm::dvec3;

Emitter makeEmitter(const Scene& scene, uint32_t index, bool from_front, const PolygonTree& near) {
  const Polygon& polygon = scene.polygons[index];
  const dvec3* const c = &scene.corners[polygon.first_corner];
  const dvec3& last = c[polygon.corner_count - 1];
  const dvec3 front = frontNormal(scene, polygon), normal = from_front ? front : -front,
              across = glm::normalize(glm::cross(normal, std::abs(normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  Emitter emitter{.corner = c[0],
                  .corners = {pointOf(c[1] - c[0]), pointOf(c[2] - c[0]), pointOf(last - c[0])},
                  .along_first = pointOf(c[2] - c[1]),
                  .along_second = pointOf(last - c[2]),
                  .first_share = 1,
                  .reach = reachOf(scene, polygon),
                  .axes = {pointOf(across), pointOf(glm::cross(normal, across)), pointOf(normal)},
                  .covers = {}};
  if (polygon.corner_count == 4)
    emitter.first_share = static_cast<float>(glm::length(glm::cross(c[1] - c[0], c[2] - c[0])) / (2 * polygon.area));
  std::vector<std::pair<int, uint32_t>> covers;
  near.forEachNear(index, kCoincidenceReach, [&](uint32_t other) {
    const int steps =
        (levelOf(scene.polygons[other]) - levelOf(polygon)) * (polygon.front_along_plane_normal == from_front ? 1 : -1);
    if (scene.polygons[other].plane == polygon.plane && steps > 0) covers.emplace_back(steps, other);
  });
  std::ranges::sort(covers);
  for (const auto& [steps, other] : covers) emitter.covers.push_back(RayTree::facetOf(scene, other));
  return emitter;
}

}  // namespace

std::vector<Emitter> makeEmitters(const Scene& scene, uint32_t sides) {
  const PolygonTree near(scene);
  std::vector<Emitter> emitters;
  emitters.reserve(scene.polygons.size() * sides);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k)
    for (uint32_t side = 0; side < sides; ++side) emitters.push_back(makeEmitter(scene, k, side == 0, near));
  return emitters;
}

}  // namespace viewpeel
