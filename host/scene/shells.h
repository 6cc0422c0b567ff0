// Shells: faces that hang together by their edges, and which of them are turned the wrong way.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "scene/sight.h"

namespace viewpeel {

struct Shell {
  std::vector<uint32_t> faces;   // of Scene::faces, ascending
  std::vector<bool> is_against;  // of each: its front is on the other side than that of most of the shell's area
  bool is_closed = false;        // every edge is met by others of the shell, once in each direction after turning
  bool is_twisted = false;       // faces cannot all be turned to one side, as those of a Moebius strip
};

// Two faces at an edge hang together. Of more than two at an edge those of one surface do, then those with the smallest
// wedge of space or solid between them. T-junctions are cut where fewer than 4,000 edges are open.
//   Cost: O(edges log edges).
std::vector<Shell> findShells(const Scene& scene);

// Faces to turn over so that lines meet fronts: those that are against their shells; closed shells whose backs other
// fronts see while their own fronts see (almost) no others: a solid inside out, a room with its normals outward; open
// shells whose backs end (almost) all rays on other fronts, while their fronts see none; and the one closed shell of a
// scene in which no front sees anything.
//   Error: from some thousand rays, the same in every run; shells that fewer than 4 rays tell of stay as they are.
//   Out: ascending, Scene::faces
//   Cost: O(edges log edges) and at most 2^18 rays, 8 for each side of a shell at least, for each of 4 turns.
std::vector<uint32_t> findFlipped(const Scene& scene, const std::vector<Shell>& shells, Sight& sight);

}  // namespace viewpeel
