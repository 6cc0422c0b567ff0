// Two rivals run on Embree, both on all cores. One shoots rays. The other samples the double area integral, with one
// visibility ray for each sample.
#pragma once
#include <vector>

#include "bench/rivals/embree_scene.h"
#include "bench/support/exchange_matrix.h"
#include "bench/support/points.h"

namespace viewpeel::bench {

// RayCounts are counts of ray shooting. Rays of polygon i that end on the front of j measure F_ij; rays of j measure
// the same exchange area once more.
struct RayCounts {
  struct Hits {
    uint32_t from, to, count;
  };
  std::vector<Hits> hits;  // in no order; a pair may come several times
  uint64_t rays_per_polygon = 0;
};

// A RayEstimate has exchange areas, unit-ball units squared, of both directions with the weights that leave the least
// variance. With N rays from each polygon the variance of A_i F_ij from i is A_i C / N, small F, so the weights of i
// and j are as 1 / A_i and 1 / A_j:
//   A_i F_ij = (hits_ij + hits_ji) / (N / A_i + N / A_j).
// The plain average has (A_i + A_j) C / 4 N, never less than this one's C / (N / A_i + N / A_j).
//   Out: also the rms standard error over all ordered pairs where rays are independent: each pair's variance is that of
//     its hits
struct RayEstimate {
  ExchangeMatrix exchange;
  double rms_standard_error = 0;
};
RayEstimate estimateFromRays(const RayCounts& counts, const Scene& scene);

class EmbreeRays {
 public:
  // The scene stays the caller's.
  explicit EmbreeRays(const Scene& scene);

  // Shoots rays from points uniform on every polygon, by the cosine law.
  //   In: rays_per_polygon: of Sobol' points best a power of two
  RayCounts shoot(Trace trace, Points points, uint64_t rays_per_polygon, uint64_t seed) const;

  // A_i F_ij = int int cos cos V / (pi r^2) over both polygons: for every pair with fronts towards each other pairs of
  // points, V by one ray.
  //   Out: unit-ball units squared, and the rms standard error over all ordered pairs where points are independent, 2
  //   or more
  RayEstimate integrate(Trace trace, Points points, uint32_t samples_per_pair, uint64_t seed) const;

 private:
  // An Emitter is a convex polygon as one or two triangles, chosen by area: a parallelogram needs no choice.
  struct Emitter {
    glm::vec3 origin, a, b,
        c;            // a triangle origin, a, b, and where it has four corners one of b, c: sides from the origin
    float share = 1;  // of the first triangle
    bool parallelogram = false;
    glm::vec3 x, y, normal;  // orthonormal
    float away = 0;          // where rays from and to it start and end
  };
  static glm::vec3 pointOn(const Emitter& emitter, uint32_t s, uint32_t t);

  const Scene& scene_;
  EmbreeScene embree_;
  std::vector<Emitter> emitters_;
};

}  // namespace viewpeel::bench
