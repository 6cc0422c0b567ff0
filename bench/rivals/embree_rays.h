// EmbreeRays has three rivals that trace rays by Embree on all cores. One shoots rays from polygons, one follows paths
// of radiation. The third samples the double area integral, with one visibility ray for each sample.
#pragma once
#include <vector>

#include "bench/rivals/embree_scene.h"
#include "bench/support/exchange_matrix.h"
#include "bench/support/points.h"

namespace viewpeel::bench {

// RayCounts are the hits of rays. Rays from polygon i that end on the front of j measure F_ij; rays from j measure the
// same exchange area again.
struct RayCounts {
  struct Hits {
    uint32_t from, to, count;
  };
  std::vector<Hits> hits;  // unordered; a pair may occur several times
  uint64_t rays_per_polygon = 0;
};

// RayEstimate has exchange areas, unit-ball units squared. Each combines the rays of both polygons with the weights of
// least variance. With N rays from each polygon, C = A_i F_ij is estimated by A_i hits_ij / N, with the variance
// A_i C / N for small F. So i and j have weights in the ratio of 1 / A_i and 1 / A_j:
//   A_i F_ij = (hits_ij + hits_ji) / (N / A_i + N / A_j).
// The variance is C / (N / A_i + N / A_j). That of the plain mean, (A_i + A_j) C / 4 N, is never smaller.
//   Out: for independent rays also the rms standard error over all ordered pairs, where the variance of a pair is that
//     of its hits
struct RayEstimate {
  ExchangeMatrix exchange;
  double rms_standard_error = 0;
};
RayEstimate estimateFromRays(const RayCounts& counts, const Scene& scene);

class EmbreeRays {
 public:
  // The scene has to outlive this object.
  explicit EmbreeRays(const Scene& scene);

  // Shoots rays from points uniform on every polygon, by the cosine law.
  //   In: rays_per_polygon: for Sobol' points best a power of two
  RayCounts shoot(Trace trace, Points points, uint64_t rays_per_polygon, uint64_t seed) const;

  // Follows paths of radiation until they are absorbed or leave the scene. A polygon that a path reaches absorbs it,
  // with the probability of its absorptivity. Else it sends the path on by the cosine law, from a point uniform on the
  // polygon: each polygon has one radiosity, as in a solution from form factors.
  //   In: power: that each polygon emits, of either sign; absorptivity: in [0, 1]; paths: over all polygons
  //   Out: power that arrives at each polygon, in the unit of `power`
  std::vector<double> tracePaths(Trace trace, const std::vector<double>& power, const std::vector<double>& absorptivity,
                                 uint64_t paths, uint64_t seed) const;

  // Estimates A_i F_ij = int int cos cos V / (pi r^2) over both polygons, for every pair whose fronts look at each
  // other. Each sample is a pair of points, and one ray finds its V.
  //   Out: unit-ball units squared; for 2 or more independent points also the rms standard error over all ordered pairs
  RayEstimate integrate(Trace trace, Points points, uint32_t samples_per_pair, uint64_t seed) const;

 private:
  // Emitter is a convex polygon as one or two triangles. Rays choose a triangle by area; a parallelogram needs no
  // choice.
  struct Emitter {
    glm::vec3 origin, a, b,
        c;            // sides from the origin; triangles are (origin, a, b) and, with four corners, (origin, b, c)
    float share = 1;  // area of the first triangle over the polygon's area
    bool parallelogram = false;
    glm::vec3 x, y, normal;  // orthonormal
    float away = 0;          // distance at which rays from and to it start and end, unit-ball units
  };
  static glm::vec3 pointOn(const Emitter& emitter, uint32_t s, uint32_t t);

  const Scene& scene_;
  EmbreeScene embree_;
  std::vector<Emitter> emitters_;
};

}  // namespace viewpeel::bench
