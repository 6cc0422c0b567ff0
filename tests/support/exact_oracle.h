// The oracle computes the areas of pairs in slow, plain ways, which share only the facing rules with the exact path.
#pragma once
#include <cstdint>
#include <map>
#include <utility>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel::tests {

using AreaMap = std::map<std::pair<uint32_t, uint32_t>, double>;  // (a, b), a < b -> area in P(u)

// SlabAreas has the plane cut into slabs between all x of end points and crossings, the slabs into trapezoids by all
// edges; each trapezoid's layers sorted by exact height at its middle. Rational numbers throughout, rounded once per
// trapezoid.
//   Error: 1e-15 per trapezoid of a pair.
//   Cost: O(crossings x edges x polygons) rational operations: small scenes only.
struct SlabAreas {
  AreaMap pairs, blocked;
};
SlabAreas cutIntoSlabs(const Scene& scene, const glm::dvec3& u, bool two_sided = false);

// Samples does the same at random lines along u through a square that covers the projection: the share of lines times
// its area.
//   Error: standard deviation sqrt(area (square - area) / samples).
//   Cost: O(samples x polygons), double.
struct Samples {
  AreaMap areas;
  double square = 0;  // area that was sampled
};
Samples sampleLines(const Scene& scene, const glm::dvec3& u, uint32_t sample_count, uint32_t seed);

// Returns the common part of two projected polygons, by clipping in double.
struct Overlap {
  double area = 0;    // in P(u)
  double height = 0;  // of b's plane above a's in its middle, along u
};
Overlap overlap(const Scene& scene, const glm::dvec3& u, uint32_t a, uint32_t b);

}  // namespace viewpeel::tests
