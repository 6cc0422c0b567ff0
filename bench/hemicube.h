// The hemicube as a rival, on the same Vulkan device, by its raster pipeline (M. F. Cohen & D. P. Greenberg, The hemi-cube, SIGGRAPH 1985).
#pragma once
#include <memory>

#include "exchange_matrix.h"
#include "scene/scene.h"
#include "vulkan/device.h"

namespace viewpeel::bench {

class Hemicube {
 public:
  //   In: resolution: pixels along an edge, even; the scene and the device stay the caller's
  //   Throws: Error device.
  Hemicube(const Device& device, const Scene& scene, uint32_t resolution);
  ~Hemicube();

  // Hemicubes on points of every polygon, each turned at random about the normal: one at the middle, several at scrambled Sobol' points.
  //   Out: A_i F_ij = (F_ij + F_ji) / (1 / A_i + 1 / A_j), unit-ball units squared: both directions, weighted as rays are (embree_rays.h)
  //   Cost: points x polygons hemicubes of 5 draws of the whole scene.
  ExchangeMatrix compute(uint32_t points_per_polygon, uint64_t seed);
  // One hemicube, for nothing: the first draw compiles.
  void lookOnce();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace viewpeel::bench
