// Coincident polygons that look opposite ways are the two sides of a thin sheet, or the contact of touching solids.
//
// The polygons alone are the same data: a baffle drawn as two faces, and a box standing on a floor. Their surroundings
// decide (docs/method.md, section 3). Space on either side of a sheet is free; on either side of a contact it is the
// inside of a solid. A ray from a point beside the polygons decides. It leaves a solid through one more back than it
// hits fronts, whatever other solids it passes or shares this solid with. So rays from points of every overlap vote.
// The polygons of one plane are put in an order along its normal (Polygon::tie_rank), as if they lay an infinitesimal
// distance apart. Engines order equal depths by these ranks. Of polygons that overlap and look the same way each has a
// rank of its own, so that a line and the opposite one count for the same polygon.
#pragma once
#include <vector>

#include <viewpeel/scene.h>
#include "facing.h"

namespace viewpeel {

// Returns the place of a polygon among the coincident ones of its plane, rising along the plane's normal.
inline int levelOf(const Polygon& polygon) {
  return static_cast<int>(placeAtTie(polygon.front_along_plane_normal, polygon.tie_rank));
}

// Polygons whose planes are nearer than this to each other over all of their overlap coincide, unit-ball units: some
// units in the last place of coordinates in single precision.
constexpr double kCoincidenceReach = 2e-6;

// An AlikeOverlap is two polygons of different faces that look the same way and overlap in one plane, with nothing
// between them. They may be so near to one plane that engines take them for coplanar: a line ends on either.
struct AlikeOverlap {
  uint32_t a, b;  // polygons, a < b
  double area;    // of their common part, unit-ball units squared
};

// Sets Polygon::tie_rank and Scene::coincidences, and returns the overlaps of polygons that look the same way. These
// overlaps are wider than two kCoincidenceReach, or than 1e-3 of the narrower polygon's width where this is less, and
// than the rounding.
//   Where rounding has put coincident polygons in another order than the one found, it also moves them into one plane.
//     Every corner at the very same place moves along: by kCoincidenceReach at most, a corner of several such planes by
//     as much for each.
//   Of two that look the same way the first in the file lies in front, unless others that overlap them are against it
//     (tie_ranks.h). Coincidences::alike_unordered counts pairs whose order is left to the direction.
//   Rays that hit other coincident polygons wait until these are ordered. Where no ray decides, the gap between two
//     polygons does; without a gap they are a sheet. Coincidences::in_doubt counts pairs whose rays contradict each
//     other or never ended, and a warning names the first contradiction.
//   In: scene with planes; options: surfaces whose coincident faces are sheets or solids, whatever lies around;
//     rounding: of coordinates, unit-ball units: gaps up to this decide nothing
//   Throws: Error bad_usage for names that are no surface's, or that are both.
//   Tests: tests/unit/coincident_test.cpp
//   Cost: O(n log n), and some 30 rays for each pair of coincident polygons, O(log n) each.
std::vector<AlikeOverlap> orderCoincidentPolygons(Scene& scene, const SceneOptions& options, double rounding);

}  // namespace viewpeel
