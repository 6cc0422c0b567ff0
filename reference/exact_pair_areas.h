// The exact path: pair areas of one direction without a lattice.
//
// Method: Pellegrini 1997, section 6: the scene projected along u is cut into faces over each of which the order of polygons is constant;
// every consecutive facing pair gets the face's area. The projection is a shear onto a coordinate plane, which keeps coordinates rational;
// the faces are those of CGAL's arrangement of the projected edges (exact predicates, exact constructions, filtered by intervals).
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "matrix/pair_count.h"
#include "scene/scene.h"

namespace viewpeel::reference {

// Polygons a <= b are consecutive and facing over a region of the projection; b may be kEnvironment or kLeak.
struct PairArea {
  uint32_t a, b;     // Scene::polygons
  double area;       // of the region in P(u), unit-ball units squared
  double perimeter;  // of the region in P(u), unit-ball units
};

struct ExactOptions {
  bool two_sided = false;
  // Also sum all areas as rational numbers: see largest_sum_defect. Slow: for tests.
  bool check_sums = false;
};

struct PairAreas {
  std::vector<PairArea> pairs;  // sorted by (a, b), areas above 0
  uint64_t edge_count = 0;      // of the arrangement: grows with the crossings of projected edges
  // With check_sums: the largest difference between a polygon's exact projected area (twice that when two-sided) and the exact sum of the
  // areas of its pairs, environment and leak, over all polygons. Exactly 0 when nothing is lost or counted twice.
  double largest_sum_defect = 0;
};

// Computes A'_ij(u) for all pairs that are consecutive and facing (host/facing.h).
//   In: interior-disjoint convex polygons; direction u, not zero, need not be of unit length
//   Out: see PairAreas. Polygons in one plane are ordered at equal height by facing, those whose fronts face +u first, then by index: touching
//     solids face each other. Polygons with |normal . u| below 1e-12 |u| or no projected area contribute nothing.
//   Error: areas are exact but for the rounding of each face's area to double, below 1e-15; tests/exact_test.cpp checks the sums as rationals.
//     Polygons that interpenetrate by less than kInterpenetrationTolerance are ordered as at one point of each face.
//   Cost: O((n + k) log n) for k crossings of projected edges, and O(depth) for each face.
//   Source: heights as the engines have them, from Scene::planes.
PairAreas computePairAreas(const Scene& scene, const glm::dvec3& u, const ExactOptions& options = {});

// Two polygons pass through each other deeper than this, unit-ball units: a hundred times what rounding of coordinates and planes explains.
constexpr double kInterpenetrationTolerance = 1e-9;

struct Interpenetration {
  uint32_t a, b;     // Scene::polygons
  glm::dvec3 place;  // a common point, unit-ball units
};

// All pairs of polygons that pass through each other; touching along edges, at corners or in a plane is none.
//   Error: decided in double with kInterpenetrationTolerance.    Cost: O(n log^2 n + pairs of overlapping boxes).
std::vector<Interpenetration> findInterpenetrations(const Scene& scene);

// One line that names both polygons and the place in input coordinates.
std::string describe(const Scene& scene, const Interpenetration& interpenetration);

}  // namespace viewpeel::reference
