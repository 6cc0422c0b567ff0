// Polygons that pass through each other. Their order changes along the lattice row of a scanline, which scanlines take
// for constant between the ends of spans; lattice points order them point by point.
#pragma once
#include <optional>
#include <utility>

#include <viewpeel/scene.h>

namespace viewpeel {

// Polygons cross if they reach farther than this into each other, unit-ball units. Coordinates in single precision
// differ by less where polygons are meant to touch, and lines so near to a crossing are few.
constexpr double kCrossingDepth = 1e-6;

// Two polygons that cross, if any do: each has corners farther than kCrossingDepth on both sides of the other's plane,
// and the chords that they cut from the common line of the planes overlap by more than that.
//   Out: indices into Scene::polygons, or nothing    Throws: nothing    Tests: tests/unit/crossings_test.cpp
//   Cost: O(n log n + pairs of overlapping boxes), to the first pair that crosses.
std::optional<std::pair<uint32_t, uint32_t>> findCrossing(const Scene& scene);

}  // namespace viewpeel
