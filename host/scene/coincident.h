// Two coincident polygons that look opposite ways are either the two sides of a thin sheet, or the contact of touching
// solids. orderCoincidentPolygons() finds out which, and orders the polygons of each plane.
//
// The two polygons alone do not tell a baffle drawn as two faces from a box that stands on a floor. The polygons around
// them do (docs/method.md, section 3). On either side of a sheet space is free. On either side of a contact there is
// the inside of a solid. A ray from a point beside the polygons tells the two apart: a ray that starts inside a solid
// leaves through one more back than it hits fronts. Other solids on its way do not change this. So rays from points of
// every overlap vote. The polygons of one plane get an order along its normal (Polygon::tie_rank), as if they lay an
// infinitesimal distance apart. Engines order equal depths by these ranks. Polygons that overlap and look the same way
// have different ranks, so that a line and the opposite line count for the same polygon.
#pragma once
#include <vector>

#include <viewpeel/scene.h>
#include "facing.h"

namespace viewpeel {

// Returns the position of a polygon among the coincident polygons of its plane, counted along the plane's normal.
inline int levelOf(const Polygon& polygon) {
  return static_cast<int>(placeAtTie(polygon.front_along_plane_normal, polygon.tie_rank));
}

// Two polygons coincide where their planes are nearer to each other than this over their whole overlap, in unit-ball
// units. It is a few units in the last place of coordinates in single precision.
constexpr double kCoincidenceReach = 2e-6;

// An AlikeOverlap is a pair of polygons of different faces that look the same way, coincide, and have nothing between
// them. Engines may take the two for coplanar, and a line then ends on either of them.
struct AlikeOverlap {
  uint32_t a, b;  // polygons, a < b
  double area;    // of their common part, unit-ball units squared
};

// Sets Polygon::tie_rank and Scene::coincidences, and returns the overlaps of polygons that look the same way.
//   An overlap is returned if it is wider than the rounding, and wider than two kCoincidenceReach or 1e-3 of the
//     narrower polygon's width, whichever is less.
//   Where rounding has put coincident polygons in another order than the one found here, the function moves them into
//     one plane. Other corners at exactly the same place move along. A corner moves by at most kCoincidenceReach for
//     each plane.
//   Of two polygons that look the same way, the first in the file lies in front, unless the order of other polygons
//     that overlap them contradicts this (tie_ranks.h). Coincidences::alike_unordered counts pairs whose order depends
//     on the direction of the line.
//   A ray that hits other coincident polygons waits until these polygons are ordered. Where no ray decides, the gap
//     between two polygons does. Two polygons without a gap become a sheet. Coincidences::in_doubt counts the pairs
//     whose rays contradict each other or never end. A warning names the first contradiction.
//   In: scene: with planes; options: the surfaces whose coincident faces are sheets or solids, whatever lies around
//     them; rounding: of coordinates, in unit-ball units; gaps up to the rounding decide nothing
//   Throws: Error bad_usage for a name that no surface has, or that is among both sheets and solids.
//   Tests: tests/unit/coincident_test.cpp
//   Cost: O(n log n), and some 30 rays for each pair of coincident polygons, O(log n) each.
std::vector<AlikeOverlap> orderCoincidentPolygons(Scene& scene, const SceneOptions& options, double rounding);

}  // namespace viewpeel
