// Coincident polygons that look opposite ways: two sides of a thin sheet, or touching solids.
//
// The polygons alone do not tell which: a baffle drawn as two faces and a box standing on a floor are the same data.
// What lies around them does. Space on either side of a sheet is free; on either side of a contact it is the inside of
// a solid. A ray from a point beside the polygons tells which: it leaves a solid through one more back than it meets
// fronts, whatever other solids it passes or shares that solid with. So rays from points of every overlap vote, and the
// polygons of one plane are put in an order along its normal (Polygon::tie_rank), as if they lay an infinitesimal
// distance apart. Engines order equal depths by these ranks. Of polygons that overlap and look the same way each has a
// rank of its own, so that a line and the opposite one count for the same polygon.
#pragma once
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Polygons whose planes are nearer than this to each other over all of their overlap coincide, unit-ball units: some
// units in the last place of coordinates in single precision.
constexpr double kCoincidenceReach = 2e-6;

// Two polygons of different faces that look the same way and overlap in one plane, or so near to it that engines do not
// tell them apart, with nothing between them: a line ends on either.
struct AlikeOverlap {
  uint32_t a, b;  // polygons, a < b
  double area;    // of their common part, unit-ball units squared
};

// Sets Polygon::tie_rank and Scene::coincidences, and returns what overlaps and looks the same way: overlaps wider than
// two kCoincidenceReach, or than 1e-3 of the narrower polygon's width where that is less, and than the rounding. Where
// rounding has put coincident polygons in another order than the one found, it also moves them into one plane, and with
// them every corner at the very same place: by kCoincidenceReach at most, a corner of several such planes by as much
// for each.
//   Of two that look the same way the first in the file lies in front, unless others that overlap them are against it
//   (tie_ranks.h). Coincidences::alike_unordered counts those whose order is left to the direction.
//   Rays that meet other coincident polygons wait until those are ordered. Where rays tell nothing, the gap between two
//   polygons decides; without a gap they are a sheet. Coincidences::in_doubt counts pairs whose rays contradict each
//   other or never ended, and a warning names the first contradiction.
//   In: scene with planes; options: surfaces whose coincident faces are sheets or solids, whatever lies around;
//     rounding: of coordinates, unit-ball units: gaps up to this tell nothing
//   Throws: Error bad_usage for names that are no surface's, or that are both.
//   Tests: tests/unit/coincident_test.cpp
//   Cost: O(n log n), and some 30 rays for each pair of coincident polygons, O(log n) each.
std::vector<AlikeOverlap> orderCoincidentPolygons(Scene& scene, const SceneOptions& options, double rounding);

}  // namespace viewpeel
