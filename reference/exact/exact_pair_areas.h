// Exact areas of every consecutive facing pair along one direction are the oracle of the rasterisers, and an engine for
// small scenes.
//
// Method: docs/method.md, section 12, eq. (39). Cut every projected edge where it enters and leaves the other projected
// polygons, and sort the polygons it lies in. All decisions are exact: the scene is sheared along u onto a coordinate
// plane, where coordinates are integers times one power of two. A filter in double decides where it safely can,
// integers decide the rest. Background: J. R. Shewchuk, Adaptive precision floating-point arithmetic (1997).
//
// Degeneracies: an edge shared by polygons is crossed one polygon at a time, in the order of their indices, as if the
// polygons were shrunk by infinitesimals of different size. No general position is assumed anywhere.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "sums/pair_count.h"
#include "scene/interpenetration.h"
#include <viewpeel/scene.h>

namespace viewpeel::reference {

// A PairArea is the area of polygons a < b that face each other; b is kEnvironment or kLeak for lines of a that end
// there.
struct PairArea {
  uint32_t a, b;
  double area;       // in P(u), unit-ball units squared
  double error;      // |area - exact area| <= error
  double perimeter;  // of the pair's regions in P(u), unit-ball units; with ExactOptions::perimeters, else 0
};

struct ExactPairAreas {
  std::vector<PairArea> pairs;    // sorted by (a, b), every pair at most once
  std::vector<PairArea> blocked;  // blocked pairs: a and b face each other past others; only with ExactOptions::blocked
  uint64_t cut_count = 0;         // places where an edge enters or leaves an outline: the size of the problem

  // Only Arithmetic::exact fills these lists, by sums of rational numbers without any rounding. The first has polygons
  // whose pairs, environment and leak do not add up to the area of their projection (twice, if two-sided).
  std::vector<uint32_t> open_polygons;
  // The second has pairs whose regions have a boundary that does not close, which the sums above cannot see.
  std::vector<std::array<uint32_t, 2>> open_pairs;
};

enum class Arithmetic {
  bounded,  // exact decisions, areas in double with a bound on their rounding
  exact,    // areas too as rational numbers, rounded once at the end; closure is verified. For tests and small scenes.
};

struct ExactOptions {
  bool two_sided = false;
  // Perimeters are computed, too. Where edges overlap in part without sharing both ends, a length that cancels may be
  // counted.
  bool perimeters = false;
  bool blocked = false;  // blocked pairs are found, too
  Arithmetic arithmetic = Arithmetic::bounded;
  double touching_depth = kTouchingDepth;  // of requireDisjoint
  unsigned thread_count = 0;               // 0: one per core
  // Any thread calls it before every direction. An exception from it ends the call. It may be empty.
  std::function<void()> on_direction;
};

// Computes A'_ab(u), the area in P(u) of the lines along u on which polygons a and b are consecutive and facing, by the
// rules of facing.h. For b = kEnvironment it is the area of the lines on which a's front sees no polygon, for b = kLeak
// the back of one.
//   Order along a line: height on the planes of the polygons (Scene::planes); at equal heights the polygon whose front
//     faces +u comes first, then the lower index. Two polygons of a valid scene keep one order on all their common
//     lines. So it is decided once per pair, exactly, where their heights differ most: corners off their plane by
//     rounding do no harm.
//   A polygon whose plane contains u, or whose projection has no area, contributes nothing. Corners that rounding makes
//     reflex in the projection are replaced by their convex hull.
//   Blocked areas are the same integral. Let X and Y be the layers next below and above polygon P along an edge of P.
//     On the inner side of the edge P has blocked pairs with all layers but X and Y, and parts the pair (X, Y).
//   In: scene in unit-ball units, polygons convex, interiors disjoint up to options.touching_depth; u finite, not zero,
//     of any length, taken as an exact rational vector.
//   Out: pairs in unit-ball units squared. Zero areas are left out; with Arithmetic::bounded also areas not above their
//     error.
//   Error: PairArea::error, of the order of 1e-15 times the number of edge pieces that bound the pair's regions; 2 ulp
//     with Arithmetic::exact. tests/unit/exact_test.cpp.
//   Throws: Error bad_input where polygons interpenetrate, naming both and the place; Error bad_usage for a useless u.
//   Cost: expected work O(n + k d), with blocked pairs O(n + k d log d). There are n edges, k cuts
//     (ExactPairAreas::cut_count) and depth complexity d, up to sorting along each edge. O(n + overlapping pairs)
//     memory. Arithmetic::exact: quadratic in the pieces around a polygon.
//   Source: M. Pellegrini, Monte Carlo approximation of form factors with error bounded a priori, section 5.
ExactPairAreas computeExactPairAreas(const Scene& scene, const glm::dvec3& u, const ExactOptions& options = {});

// Computes the areas of every direction, in parallel over options.thread_count threads, result k for directions[k].
//   Cost: as above for each direction; the scene is checked for interpenetration once.
std::vector<ExactPairAreas> computeExactPairAreas(const Scene& scene, std::span<const glm::dvec3> directions,
                                                  const ExactOptions& options = {});

}  // namespace viewpeel::reference
