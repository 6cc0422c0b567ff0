// A Sight casts rays through a scene, and finds the polygon that a point of a polygon sees in a direction. It is slow
// beside the engines: only messages, repairs of the input, and rows that common directions hardly meet use it.
#pragma once
#include <cstdint>
#include <random>
#include <vector>

#include "scene/polygon_tree.h"
#include <viewpeel/scene.h>

namespace viewpeel {

class Sight {
 public:
  static constexpr uint32_t kNothing = UINT32_MAX;
  // A random ray makes at least this cosine with the normal of the polygon that it leaves. On flatter rays the hits of
  // coincident polygons may be far apart.
  static constexpr double kLeastCosine = 0.01;
  struct End {
    uint32_t polygon = kNothing;
    bool is_front = false;
  };

  // Builds a tree over the polygons. The scene must outlive this object.    Cost: O(n log n).
  explicit Sight(const Scene& scene);

  // These functions return the next random number. The seed is fixed, so every run casts the same rays.
  uint64_t next() { return random_(); }
  double uniform() { return double(random_() >> 11) * 0x1p-53; }
  // Draws a point uniformly over the polygon.
  glm::dvec3 pointOn(uint32_t polygon);
  // Draws a direction of the cosine law, on the side of the polygon's front or of its back.
  glm::dvec3 directionFrom(uint32_t polygon, bool from_front);
  // These functions return a point of the polygon, and a direction of the cosine law. Both keep areas: numbers uniform
  // in [0, 1) give points uniform over the polygon.
  glm::dvec3 pointOn(uint32_t polygon, double u, double v) const;
  glm::dvec3 directionFrom(uint32_t polygon, bool from_front, double square_of_height, double turn) const;
  // Finds the first polygon that a ray from a point of `polygon` hits. Tie ranks order coincident polygons.
  //   Cost: O(log n + boxes hit).
  End look(uint32_t polygon, const glm::dvec3& point, const glm::dvec3& direction) const;
  End look(uint32_t polygon, bool from_front = true) {
    return look(polygon, pointOn(polygon), directionFrom(polygon, from_front));
  }

 private:
  const Scene& scene_;
  PolygonTree tree_;
  std::vector<glm::dvec3> normals_;  // front normal of each polygon
  std::mt19937_64 random_{1};
};

// Returns the cumulative sums of the areas of some polygons, for pickBySums().
std::vector<double> sumAreas(const Scene& scene, const std::vector<uint32_t>& polygons);

// Returns the first entry whose cumulative sum is above `at`.
//   In: sums: cumulative sums of weights, ascending; at: from 0 to the last sum
uint32_t pickBySums(const std::vector<double>& sums, double at);

}  // namespace viewpeel
