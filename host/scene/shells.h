// Shells are faces that hang together by their edges, and which of them are turned the wrong way.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "scene/sight.h"

namespace viewpeel {

struct Shell {
  std::vector<uint32_t> faces;   // of Scene::faces, ascending
  std::vector<bool> is_against;  // of each: its front is on the other side than most of the shell's area
  bool is_closed = false;        // every edge has others of the shell, once in each direction after turning
  bool is_twisted = false;       // faces cannot all be turned to one side, as in a Moebius strip
};

// Finds shells: two faces at an edge hang together. Of more than two at an edge the faces of one surface do, then faces
// with the smallest wedge of space or solid between them. T-junctions are cut where fewer than 4,000 edges are open.
//   Cost: O(edges log edges).
std::vector<Shell> findShells(const Scene& scene);

// Finds the faces to turn over so that lines hit fronts.
//   They are faces against their shells, and whole shells of three kinds. Closed shells turn whose backs other fronts
//     see while their own fronts see (almost) no others: a solid inside out, a room with its normals outward. Open
//     shells turn whose backs end (almost) all rays on other fronts, while their fronts see none. So does the one
//     closed shell of a scene in which no front sees anything.
//   Error: from some thousand rays, the same in every run; shells that fewer than 4 rays hit stay as they are.
//   Out: ascending, Scene::faces
//   Cost: O(edges log edges) and at most 2^18 rays, 8 for each side of a shell at least, for each of 4 turns.
std::vector<uint32_t> findFlipped(const Scene& scene, const std::vector<Shell>& shells, Sight& sight);

}  // namespace viewpeel
