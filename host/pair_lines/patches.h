// A patch is one side of a polygon, on which lines start or end.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/ids.h>
#include "sums/line_sums.h"
#include "unoccluded/unoccluded.h"

namespace viewpeel {

// A patch has these roles beside kEmits and kReceives. kLeaks: lines from it may end on backs. kIsBack: it is a back.
// kOnlyBlocks: it only blocks, and lines that end on it do not reach the environment.
constexpr uint32_t kLeaks = 4, kIsBack = 8, kOnlyBlocks = 16;
static_assert((kEmits | kReceives) < kLeaks);

// Returns whether lines may run between two patches, or clusters of patches, with these roles.
inline bool mayExchange(uint32_t a, uint32_t b) {
  const auto may = [](uint32_t from, uint32_t to) {
    return ((from & kEmits) && (to & (kReceives | kOnlyBlocks))) || ((from & kLeaks) && (to & kIsBack));
  };
  return may(a, b) || may(b, a);
}

// A Patch is one side of a convex polygon with three or four corners. Lengths are in unit-ball units.
struct Patch {
  uint32_t side = 0;   // frontSide or backSide of its polygon
  uint32_t id = 0;     // id of its row; for a back on which leaking lines end: this id plus the number of rows
  uint32_t plane = 0;  // Scene::planes
  int height = 0;      // level in its plane: blockers of this plane with a higher level lie in front (stepsInFront)
  bool along_plane_normal = true;  // whether the side looks along its plane's normal
  uint32_t roles = 0;              // kEmits, kReceives, kLeaks, kIsBack, kOnlyBlocks
  bool is_part = false;            // whether its row has more polygons
  // 1: the whole side of the polygon. The halves of a patch with cut c have 2 c and 2 c + 1.
  uint32_t cut = 1;
  uint32_t corner_count = 0;
  glm::dvec3 corners[4]{};       // a triangle has its last corner twice
  glm::dvec3 normal{0};          // of the side, unit length
  double offset = 0;             // normal . x = offset
  glm::dvec3 edge_normals[4]{};  // within its plane, outwards, unit length
  double edge_offsets[4]{};
  glm::dvec3 middle{0}, low{0}, high{0};
  double area = 0;
};

// Returns a number of its own for each patch, the same for every order of patches.
inline uint64_t numberOf(const Patch& patch) { return patch.side + (uint64_t(patch.cut - 1) << 32); }

// Cuts a patch in two, across its longer way: a quadrilateral between the middles of its two longer opposite sides, a
// triangle from the middle of its longest side to the opposite corner.
std::array<Patch, 2> halvesOf(const Patch& patch);
// Returns the length that halvesOf() halves: the mean of a quadrilateral's two longer opposite sides, or a triangle's
// longest side.
double lengthOf(const Patch& patch);

// Makes patches of the sides that emit or receive, and of all backs where lines may end on them.
//   In: ids: rows and roles of polygons; ends_on_blockers: whether lines may end on sides of polygons that only block
//   Cost: O(polygons).
std::vector<Patch> makePatches(const Scene& scene, const Ids& ids, const LeakingFaces& leaking,
                               bool ends_on_blockers = false);

}  // namespace viewpeel
