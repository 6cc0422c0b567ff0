// Sides of polygons as ends of lines.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/ids.h>
#include "unoccluded/unoccluded.h"

namespace viewpeel {

// One side of a convex polygon with three or four corners. Lengths in unit-ball units.
struct Patch {
  uint32_t side = 0;   // frontSide or backSide of its polygon
  uint32_t id = 0;     // of its row; of a back that lines leak to, the number of rows and its row's
  uint32_t plane = 0;  // Scene::planes
  int height = 0;      // levels of blockers of this plane that lie in front of the side are above it, see isInFront
  bool along_plane_normal = true;  // whether the side looks along its plane's normal
  bool emits = true, receives = true;
  uint32_t corner_count = 0;
  glm::dvec3 corners[4]{};       // a triangle's last twice
  glm::dvec3 normal{0};          // of the side, unit length
  double offset = 0;             // normal . x = offset
  glm::dvec3 edge_normals[4]{};  // within its plane, outwards, unit length
  double edge_offsets[4]{};
  glm::dvec3 middle{0}, low{0}, high{0};
  double area = 0;
};

// The sides that emit or receive.
//   In: ids of the scene's polygons, with their roles; with_backs: whether backs that lines leak to are among them
//   Cost: O(polygons).
std::vector<Patch> makePatches(const Scene& scene, const Ids& ids, bool with_backs);

}  // namespace viewpeel
