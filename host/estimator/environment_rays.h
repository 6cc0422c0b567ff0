// EnvironmentRays casts rays from single rows. Common directions say little of a row that few of their lines meet, such
// as a small triangle among large ones; rays of its own say more.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/sight.h"
#include <viewpeel/ids.h>

namespace viewpeel {

class EnvironmentRays {
 public:
  // In: up: of any length above 0    Keeps references to the scene and to ids.    Cost: O(polygons log polygons).
  EnvironmentRays(const Scene& scene, const Ids& ids, const glm::dvec3& up, uint64_t seed);

  // Makes points for up to this many rays. Call it before cast(), on one thread.
  void prepare(uint32_t rays);

  struct Shares {
    double up = 0, down = 0;
  };
  // Returns the shares of a replicate's rays that leave the scene above and below the horizon.
  //   In: rays: starts uniform over the row, directions of the cosine law
  //   Method: points of Sobol's sequence in five dimensions, shifted modulo 1 (Cranley and Patterson 1976). Rows and
  //     replicates have shifts of their own.
  //   Error: unbiased; Sight orders polygons that coincide.    Cost: O(log polygons) a ray; 2 us in cities.
  Shares cast(uint32_t row, uint32_t rays, uint32_t replicate) const;

 private:
  static constexpr uint32_t kDimensions = 5;

  Sight sight_;
  glm::dvec3 up_;
  uint64_t seed_;
  bool two_sided_;
  std::vector<std::vector<uint32_t>> polygons_;  // of each row
  std::vector<std::vector<double>> area_sums_;   // of each row, cumulative over its polygons
  std::vector<std::array<double, kDimensions>> points_;
};

}  // namespace viewpeel
