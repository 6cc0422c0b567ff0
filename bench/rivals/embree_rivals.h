// The same facing pairs by Embree 3, two ways: rays from the surfaces, and whole lines through a lattice. Both use all
// cores, count into the host engine's tables, and answer the same question on the same scene, so that their speed can
// be set beside viewpeel's.
#pragma once
#include <memory>
#include <span>

#include <viewpeel/engine.h>
#include "bench/rivals/embree_scene.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel::bench {

struct RayCount {
  uint64_t rays = 0;
  uint64_t samples = 0;  // rays that ended on a front, of either side where both are fronts
};

class EmbreeRivals {
 public:
  //   Throws: Error bad_input where a polygon is neither triangle nor parallelogram.
  EmbreeRivals(const Scene& scene, const Ids& ids);
  ~EmbreeRivals();

  // Global lines: all hits of the lattice's lines along every direction, sorted, and every gap counted by
  // shaders/facing.h. The lines are those of viewpeel's lattice, to rounding in 32-bit floats, without those that pass
  // the unit ball by. Returns the number of facing pairs.
  uint64_t countLines(Trace trace, std::span<const Direction> directions, int resolution);

  // Ray shooting: rays from uniform points on all polygons in turn, 64 from each, by the cosine law; what they hit
  // first is counted.
  RayCount shootRays(Trace trace, uint64_t ray_count, uint64_t seed);

  // What both have counted since the last call, in order.
  PairCounts takeCounts();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace viewpeel::bench
