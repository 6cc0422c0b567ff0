// A PolygonTree finds the polygons of a scene that are near a place or on a ray. It is an R-tree over their boxes (A.
// Guttman, R-trees: a dynamic index structure for spatial searching, 1984), from Boost.Geometry.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

class PolygonTree {
 public:
  // Keeps a reference to the scene.    Cost: O(n log n).
  explicit PolygonTree(const Scene& scene);
  ~PolygonTree();

  // Calls use(other) for every polygon whose box comes within `reach` of the box of `polygon`, and for `polygon`
  // itself.
  //   In: reach: unit-ball units    Cost: O(log n + found) where boxes overlap little.
  void forEachNear(uint32_t polygon, double reach, const std::function<void(uint32_t)>& use) const;

  struct Hit {
    double distance;
    uint32_t polygon;
    glm::dvec3 point;
    bool is_front;  // the ray arrives on the polygon's front
  };
  // Returns the polygons that a ray hits farther than `least_distance` from its origin, nearest first.
  //   In: direction: unit length    Error: points within 1e-14 of an edge count as inside.
  //   Cost: O(log n + boxes hit).
  std::vector<Hit> cast(const glm::dvec3& origin, const glm::dvec3& direction, double least_distance) const;

 private:
  struct Boxes;
  const Scene& scene_;
  std::unique_ptr<Boxes> boxes_;
};

}  // namespace viewpeel
