// Polygons that pass through one another are found here. The exact path refuses such scenes, for no order along a line
// holds over a region. Scanlines cannot count them, for they take the order for constant between the ends of spans.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

// Contact up to this depth, in unit-ball units, is touching. It is far above the rounding of corners (1e-16), far below
// anything a model means.
constexpr double kTouchingDepth = 1e-9;

// Scanlines have a larger depth: coordinates in single precision differ by less where polygons are meant to touch, and
// lines so near to a crossing are few.
constexpr double kCrossingDepth = 1e-6;

struct Interpenetration {
  uint32_t a, b;     // polygons, a < b
  glm::dvec3 place;  // input units: the middle of the segment that they share
  double length;     // of that segment, unit-ball units
};

// Finds all pairs of polygons that pass through one another.
//   Each has corners on both sides of the other's plane, further from it than `touching_depth`. The chords that they
//     cut from the common line of the planes overlap by more than `touching_depth`. Touching in corners, in edges, of
//     an edge with an interior, and overlap within one plane do not count.
//   In: scene, unit-ball units; touching_depth in unit-ball units, at least 1e-14.
//   Out: sorted by (a, b).
//   Error: decided in double, whose error (1e-15) is far below touching_depth; tests/unit/interpenetration_test.cpp.
//   Throws: nothing of its own.
//   Cost: O(n log n + overlapping boxes) work, O(n) memory.
//   Source: T. Moeller, A fast triangle-triangle intersection test (1997), for convex polygons; boxes: PolygonTree.
std::vector<Interpenetration> findInterpenetrations(const Scene& scene, double touching_depth = kTouchingDepth);

// Returns one line for a message: `scene.obj: desk[3] and wall pass through each other at (1.5, 2, 0)`.
std::string describe(const Scene& scene, const Interpenetration& found);

// Returns where the scene has no interpenetration.
//   In, Error, Cost: as findInterpenetrations.
//   Out: none.
//   Throws: Error bad_input, the first pair described, the number of further ones and the remedy.
void requireDisjoint(const Scene& scene, double touching_depth = kTouchingDepth);

}  // namespace viewpeel
