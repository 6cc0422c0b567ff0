// findShells() finds the shells of a scene: sets of faces that share edges. findFlipped() finds the faces that are
// turned the wrong way.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>
#include "scene/sight.h"

namespace viewpeel {

struct Shell {
  std::vector<uint32_t> faces;   // indices into Scene::faces, ascending
  std::vector<bool> is_against;  // for each face: its front is not on the side where most of the shell's fronts are
  bool is_closed = false;  // every edge belongs to two faces of the shell, which run along it in opposite directions
  // Where a shell is open, and all open edges lie on one side of the scene's bounding box: a point of these edges, in
  // Scene's coordinates. No line between two faces passes through such an opening.
  std::optional<glm::dvec3> outer_opening;
  bool is_twisted = false;  // faces cannot all be turned to one side, as in a Moebius strip
};

// Finds the shells. Two faces that share an edge belong to one shell. Where more than two faces share an edge, faces of
// one surface are joined first, then faces with the smallest wedge between them. Where fewer than 4,000 edges are open,
// edges are cut at T-junctions before they are compared.
//   Cost: O(edges log edges).
std::vector<Shell> findShells(const Scene& scene);

// Returns the shell of each face: uint32_t[face_count], indices into shells.
std::vector<uint32_t> shellsOfFaces(const std::vector<Shell>& shells, size_t face_count);

// Returns the volume between a polygon and an apex, in Scene's unit. It is above 0 where the polygon's back looks to
// the apex. The volumes of a closed shell's polygons add up to what its fronts enclose, whatever the apex.
double volumeBehind(const Scene& scene, const Polygon& polygon, const glm::dvec3& apex);

// Finds the faces that have to be turned over so that lines hit fronts.
//   It finds faces that are against their shell, and all faces of three kinds of shells. The first kind is a closed
//     shell whose backs other fronts see, while its fronts see almost nothing: a solid inside out, or a room with its
//     normals outward. The second kind is an open shell whose backs see almost only fronts, while its fronts see none.
//     The third kind is the only closed shell of a scene in which no front sees anything.
//   Error: the answer rests on some thousand rays, the same in every run. A shell that fewer than 4 rays hit is not
//     turned.
//   Out: indices into Scene::faces, ascending
//   Cost: O(edges log edges) and at most 2^18 rays, 8 for each side of a shell at least, for each of 4 turns.
std::vector<uint32_t> findFlipped(const Scene& scene, const std::vector<Shell>& shells, Sight& sight);

}  // namespace viewpeel
