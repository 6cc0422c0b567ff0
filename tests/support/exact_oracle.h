// The oracle computes areas of pairs in slow, plain ways. It shares only the facing rules with the exact path.
#pragma once
#include <cstdint>
#include <map>
#include <utility>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel::tests {

using AreaMap = std::map<std::pair<uint32_t, uint32_t>, double>;  // (a, b), a < b -> area in P(u)

// SlabAreas are areas of facing and of blocked pairs. The plane is cut into slabs between the x coordinates of all end
// points and crossings, and edges cut the slabs into trapezoids. In each trapezoid layers are sorted by their exact
// height in its middle. All numbers are rational, and are rounded once for each trapezoid.
//   Error: 1e-15 per trapezoid of a pair.
//   Cost: O(crossings x edges x polygons) rational operations: small scenes only.
struct SlabAreas {
  AreaMap pairs, blocked;
};
SlabAreas cutIntoSlabs(const Scene& scene, const glm::dvec3& u, bool two_sided = false);

// Samples are areas of facing pairs from random lines along u through a square that covers the projection: the share of
// lines times the area of the square.
//   Error: standard deviation sqrt(area (square - area) / samples).
//   Cost: O(samples x polygons), double.
struct Samples {
  AreaMap areas;
  double square = 0;  // area of the square
};
Samples sampleLines(const Scene& scene, const glm::dvec3& u, uint32_t sample_count, uint32_t seed);

// Returns the common part of two projected polygons, by clipping in double.
struct Overlap {
  double area = 0;    // in P(u)
  double height = 0;  // of b's plane above a's in its middle, along u
};
Overlap overlap(const Scene& scene, const glm::dvec3& u, uint32_t a, uint32_t b);

}  // namespace viewpeel::tests
