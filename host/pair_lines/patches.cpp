#include "pair_lines/patches.h"

#include <algorithm>

#include <glm/glm.hpp>

#include "scene/coincident.h"

namespace viewpeel {
namespace {

// Fills in what follows from a patch's corners and normal.
void measure(Patch& patch) {
  patch.middle = glm::dvec3(0), patch.low = glm::dvec3(INFINITY), patch.high = glm::dvec3(-INFINITY);
  for (const glm::dvec3& corner : patch.corners) {
    patch.middle += corner / 4.0;
    patch.low = glm::min(patch.low, corner), patch.high = glm::max(patch.high, corner);
  }
  const double turn = patch.side % 2 == 0 ? 1 : -1;  // corners run clockwise, seen from a back
  for (uint32_t k = 0; k < patch.corner_count; ++k) {
    const glm::dvec3 along = patch.corners[(k + 1) % patch.corner_count] - patch.corners[k];
    patch.edge_normals[k] = glm::normalize(glm::cross(along, patch.normal)) * turn;
    patch.edge_offsets[k] = glm::dot(patch.edge_normals[k], patch.corners[k]);
  }
}

Patch patchOf(const Scene& scene, uint32_t index, bool is_front, uint32_t roles) {
  const Polygon& polygon = scene.polygons[index];
  Patch patch;
  patch.side = is_front ? frontSide(index) : backSide(index);
  patch.plane = polygon.plane;
  patch.along_plane_normal = polygon.front_along_plane_normal == is_front;
  patch.height = patch.along_plane_normal ? levelOf(polygon) : -levelOf(polygon);
  patch.roles = roles;
  patch.corner_count = polygon.corner_count;
  patch.normal = frontNormal(scene, polygon) * (is_front ? 1.0 : -1.0);
  patch.area = polygon.area;
  for (uint32_t k = 0; k < 4; ++k) {
    patch.corners[k] = scene.corners[polygon.first_corner + std::min(k, polygon.corner_count - 1)];
    patch.offset += glm::dot(patch.normal, patch.corners[k]) / 4;
  }
  measure(patch);
  return patch;
}

// Returns the sum of the lengths of a quadrilateral's sides 0 and 2, or 1 and 3.
double oppositeSides(const Patch& patch, int first) {
  const glm::dvec3* const c = patch.corners;
  return glm::length(c[first + 1] - c[first]) + glm::length(c[(first + 3) % 4] - c[first + 2]);
}

// Returns the number of the first corner of a triangle's longest side.
int longestSide(const Patch& triangle) {
  const glm::dvec3* const c = triangle.corners;
  int longest = 0;
  for (int k = 1; k < 3; ++k)
    if (glm::length(c[(k + 1) % 3] - c[k]) > glm::length(c[(longest + 1) % 3] - c[longest])) longest = k;
  return longest;
}

Patch halfOf(const Patch& whole, uint32_t half, const std::array<glm::dvec3, 4>& corners) {
  Patch patch = whole;
  patch.cut = 2 * whole.cut + half;
  std::ranges::copy(corners, patch.corners);
  patch.area = glm::length(glm::cross(corners[2] - corners[0], corners[3] - corners[1])) / 2;
  measure(patch);
  return patch;
}

}  // namespace

std::array<Patch, 2> halvesOf(const Patch& patch) {
  const glm::dvec3* const c = patch.corners;
  if (patch.corner_count == 3) {
    const int k = longestSide(patch);
    const glm::dvec3 &from = c[k], &to = c[(k + 1) % 3], &apex = c[(k + 2) % 3], middle = 0.5 * (from + to);
    return {halfOf(patch, 0, {from, middle, apex, apex}), halfOf(patch, 1, {middle, to, apex, apex})};
  }
  const int k = oppositeSides(patch, 0) >= oppositeSides(patch, 1) ? 0 : 1;
  const glm::dvec3 &p = c[k], &q = c[k + 1], &r = c[k + 2], &s = c[(k + 3) % 4], near = 0.5 * (p + q),
                   far = 0.5 * (r + s);
  return {halfOf(patch, 0, {p, near, far, s}), halfOf(patch, 1, {near, q, r, far})};
}

double lengthOf(const Patch& patch) {
  if (patch.corner_count == 4) return 0.5 * std::max(oppositeSides(patch, 0), oppositeSides(patch, 1));
  const int k = longestSide(patch);
  return glm::length(patch.corners[(k + 1) % 3] - patch.corners[k]);
}

std::vector<Patch> makePatches(const Scene& scene, const Ids& ids, const LeakingFaces& leaking, bool ends_on_blockers) {
  std::vector<Patch> patches;
  const auto add = [&](uint32_t polygon, bool is_front, uint32_t roles, uint32_t id) {
    patches.push_back(patchOf(scene, polygon, is_front, roles));
    patches.back().id = id;
  };
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    uint32_t roles = ids.rolesOf(k);
    if (!roles && !ends_on_blockers) continue;
    if (!roles) roles = kOnlyBlocks;
    if ((roles & kEmits) && !leaking.of_face.empty() && leaking.of_face[ids.of_polygon[k]]) roles |= kLeaks;
    add(k, true, roles, ids.of_polygon[k]);
    if (ids.two_sided) add(k, false, roles, ids.of_polygon[k]);
  }
  const auto mayEndOnBack = [&](uint32_t id) { return leaking.backs.empty() || leaking.backs[id]; };
  if (!leaking.of_face.empty() && !ids.two_sided)
    for (uint32_t k = 0; k < scene.polygons.size(); ++k)
      if (const uint32_t id = ids.of_polygon[k]; mayEndOnBack(id)) add(k, false, kIsBack, ids.count() + id);
  std::vector<uint32_t> patch_counts(2 * ids.count());
  for (const Patch& patch : patches) ++patch_counts[patch.id];
  for (Patch& patch : patches) patch.is_part = patch_counts[patch.id] > ids.sides();
  return patches;
}

}  // namespace viewpeel
