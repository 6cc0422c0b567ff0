#include "pair_lines/patches.h"

#include <algorithm>

#include <glm/glm.hpp>

#include "scene/coincident.h"

namespace viewpeel {
namespace {

Patch patchOf(const Scene& scene, uint32_t index, bool is_front, uint32_t roles) {
  const Polygon& polygon = scene.polygons[index];
  Patch patch;
  patch.side = is_front ? frontSide(index) : backSide(index);
  patch.plane = polygon.plane;
  patch.along_plane_normal = polygon.front_along_plane_normal == is_front;
  patch.height = patch.along_plane_normal ? levelOf(polygon) : -levelOf(polygon);
  patch.emits = roles & kEmits, patch.receives = roles & kReceives;
  patch.corner_count = polygon.corner_count;
  patch.normal = frontNormal(scene, polygon) * (is_front ? 1.0 : -1.0);
  patch.area = polygon.area;
  patch.low = glm::dvec3(INFINITY), patch.high = glm::dvec3(-INFINITY);
  for (uint32_t k = 0; k < 4; ++k) {
    patch.corners[k] = scene.corners[polygon.first_corner + std::min(k, polygon.corner_count - 1)];
    patch.middle += patch.corners[k] / 4.0;
    patch.low = glm::min(patch.low, patch.corners[k]), patch.high = glm::max(patch.high, patch.corners[k]);
    patch.offset += glm::dot(patch.normal, patch.corners[k]) / 4;
  }
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    const glm::dvec3 along = patch.corners[(k + 1) % polygon.corner_count] - patch.corners[k];
    patch.edge_normals[k] = glm::normalize(glm::cross(along, patch.normal)) * (is_front ? 1.0 : -1.0);
    patch.edge_offsets[k] = glm::dot(patch.edge_normals[k], patch.corners[k]);
  }
  return patch;
}

}  // namespace

std::vector<Patch> makePatches(const Scene& scene, const Ids& ids, bool with_backs) {
  std::vector<Patch> patches;
  const auto add = [&](uint32_t polygon, bool is_front, uint32_t roles, uint32_t id) {
    patches.push_back(patchOf(scene, polygon, is_front, roles));
    patches.back().id = id;
  };
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t roles = ids.rolesOf(k);
    if (!roles) continue;
    add(k, true, roles, ids.of_polygon[k]);
    if (ids.two_sided) add(k, false, roles, ids.of_polygon[k]);
  }
  if (with_backs && !ids.two_sided)
    for (uint32_t k = 0; k < scene.polygons.size(); ++k) add(k, false, kReceives, ids.count() + ids.of_polygon[k]);
  std::vector<uint32_t> patch_counts(2 * ids.count());
  for (const Patch& patch : patches) ++patch_counts[patch.id];
  for (Patch& patch : patches) patch.is_part = patch_counts[patch.id] > 1;
  return patches;
}

}  // namespace viewpeel
