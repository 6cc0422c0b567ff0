// Embree 3 counts the same facing pairs in two ways: rays from the surfaces, and whole lines through a lattice. Both
// use all cores, count into the host engine's tables, and answer the same question on the same scene. So their speed
// can be set beside viewpeel's.
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

  // Counts global lines: all hits of the lattice's lines along every direction, sorted, and every gap by
  // shaders/facing.h. The lines are viewpeel's lattice, to rounding in 32-bit floats, without lines that pass
  // the unit ball by. Returns the number of facing pairs.
  uint64_t countLines(Trace trace, std::span<const Direction> directions, int resolution);

  // Shoots rays from uniform points on all polygons in turn, 64 from each, by the cosine law, and counts the first
  // polygon that each hits.
  RayCount shootRays(Trace trace, uint64_t ray_count, uint64_t seed);

  // Returns the counts of both since the last call, in order.
  PairCounts takeCounts();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace viewpeel::bench
