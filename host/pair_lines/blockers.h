// Blockers stand in the way of lines: they are the scene's polygons, neighbours of one plane joined to convex ones.
//
// It matters only whether something blocks a line, not which polygon does. A wall of 2,500 quadrilaterals is one
// blocker. Joining neighbours makes tests of lines against blockers cheaper, and leaves fewer pairs that only several
// blockers together hide.
#pragma once
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

constexpr uint32_t kMostBlockerCorners = 8;

// A Blocker is a convex polygon, opaque from both sides. Lengths are in unit-ball units.
struct Blocker {
  uint32_t corner_count = 0;
  uint32_t plane = 0;    // Scene::planes
  int level = 0;         // levelOf its polygons
  uint32_t polygon = 0;  // one of its polygons
  glm::dvec3 normal{0};  // by its corners' order, unit length
  double offset = 0;     // normal . x = offset
  glm::dvec3 corners[kMostBlockerCorners]{};
  glm::dvec3 edge_normals[kMostBlockerCorners]{};  // within its plane, outwards, unit length
  double edge_offsets[kMostBlockerCorners]{};
  glm::dvec3 low{0}, high{0};  // its box
};

// Makes the blockers of a scene.
//   In: a scene as buildScene makes it; join: whether neighbours become one
//   Out: blockers with the same union as all polygons, plane by plane and level by level; of_polygon: where given, the
//   blocker of each polygon
//   Error: a joined outline may leave out corners within 1e-12 of an edge's length from a straight line.
//   Cost: O(n log n) for most scenes.
std::vector<Blocker> makeBlockers(const Scene& scene, bool join = true, std::vector<uint32_t>* of_polygon = nullptr);

}  // namespace viewpeel
