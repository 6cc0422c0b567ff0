// findInterpenetrations() finds polygons that pass through one another. The exact path refuses such scenes, because no
// order along a line holds over a region. Scanlines cannot count them either: they assume one order between the ends of
// spans.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

// Polygons that enter each other by up to this depth, in unit-ball units, only touch. The depth is far above the
// rounding of corners (1e-16), and far below every dimension of a model.
constexpr double kTouchingDepth = 1e-9;

// Scanlines tolerate this larger depth. It is more than the rounding of single precision, where polygons are meant to
// touch, and few lines pass so near to a crossing.
constexpr double kCrossingDepth = 1e-6;

struct Interpenetration {
  uint32_t a, b;     // polygons, a < b
  glm::dvec3 place;  // middle of the segment that they share, input units
  double length;     // length of this segment, unit-ball units
};

// Finds all pairs of polygons that pass through one another.
//   Each polygon has corners on both sides of the other's plane, farther from it than `touching_depth`. Both
//   polygons cut a chord from the line where the planes meet, and the two chords overlap by more than
//   `touching_depth`. Polygons that only touch, at a corner, along an edge or inside, or that overlap within one
//   plane, do not count.
//   In: touching_depth: in unit-ball units, at least 1e-14
//   Out: sorted by (a, b).
//   Error: none in practice: double has an error of 1e-15, far below touching_depth. Tests:
//     tests/unit/interpenetration_test.cpp.
//   Cost: O(n log n + overlapping boxes) work, O(n) memory.
//   Source: T. Moeller, A fast triangle-triangle intersection test, 1997, extended to convex polygons.
std::vector<Interpenetration> findInterpenetrations(const Scene& scene, double touching_depth = kTouchingDepth);

// Returns one line for a message: `scene.obj: desk[3] and wall pass through each other at (1.5, 2, 0)`.
std::string describe(const Scene& scene, const Interpenetration& found);

// Refuses a scene in which polygons pass through one another.
//   In, Error, Cost: as findInterpenetrations.
//   Throws: Error bad_input, which describes the first pair, counts the others, and names the remedy.
void requireDisjoint(const Scene& scene, double touching_depth = kTouchingDepth);

}  // namespace viewpeel
