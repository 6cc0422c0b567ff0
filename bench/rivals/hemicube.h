// The hemicube is a rival that uses the raster pipeline of the same Vulkan device (M. F. Cohen & D. P. Greenberg, The
// hemi-cube, SIGGRAPH 1985).
#pragma once
#include <memory>

#include "bench/support/exchange_matrix.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel::bench {

class Hemicube {
 public:
  //   In: resolution: pixels along an edge, even; scene and device have to outlive this object
  //   Throws: Error device.
  Hemicube(const Device& device, const Scene& scene, uint32_t resolution);
  ~Hemicube();

  // Computes hemicubes at points of every polygon, each turned at random about the normal. One point is the middle;
  // several are scrambled Sobol' points.
  //   Out: A_i F_ij = (F_ij / A_i^(1/2) + F_ji / A_j^(1/2)) / (A_i^(-3/2) + A_j^(-3/2)), unit-ball units squared: both
  //     directions, weighted by A^(-3/2). The few points of a large polygon may all be far from a small neighbour. With
  //     the weights 1 / A of rays (embree_rays.h) the error would then be as large as F. Of the exponents 1, 3/2 and 2
  //     the second has the least rms error on the office with one point: 4.85e-3, 3.89e-3, 3.96e-3.
  //   Cost: points x polygons hemicubes of 5 draws of the whole scene.
  ExchangeMatrix compute(uint32_t points_per_polygon, uint64_t seed);
  // Draws one hemicube without use, for the first draw compiles.
  void lookOnce();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace viewpeel::bench
