// Sight follows rays through a scene: it finds the polygons that a point of a polygon sees. It is slow beside the
// engines, and serves messages only.
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
  struct End {
    uint32_t polygon = kNothing;
    bool is_front = false;
  };

  // Keeps a reference to the scene.    Cost: O(n log n).
  explicit Sight(const Scene& scene);

  // Every run casts the same rays.
  uint64_t next() { return random_(); }
  double uniform() { return double(random_() >> 11) * 0x1p-53; }
  // Draws a point uniformly over the polygon.
  glm::dvec3 pointOn(uint32_t polygon);
  // Draws a direction by the cosine, on the side of the polygon's front, or of its back.
  glm::dvec3 directionFrom(uint32_t polygon, bool from_front);
  // Finds the first polygon on a ray from a point of the polygon. Coincident polygons are in the order of their tie
  // ranks.
  //   Cost: O(log n + boxes hit).
  End look(uint32_t polygon, const glm::dvec3& point, const glm::dvec3& direction) const;
  End look(uint32_t polygon, bool from_front = true) {
    return look(polygon, pointOn(polygon), directionFrom(polygon, from_front));
  }

 private:
  const Scene& scene_;
  PolygonTree tree_;
  std::vector<glm::dvec3> normals_;  // of fronts
  std::mt19937_64 random_{1};
};

// Returns the entry into whose share of the sums a number falls, from 0 to the last sum.
//   In: sums: of entries 0 to k, ascending
uint32_t pickBySums(const std::vector<double>& sums, double at);

}  // namespace viewpeel
