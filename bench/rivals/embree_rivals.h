// EmbreeRivals counts facing pairs by Embree 3 in two ways: rays from the surfaces, and whole lines through a lattice.
// Both use all cores, the host engine's counters and the same scene as viewpeel, so that speeds can be compared.
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
  uint64_t samples = 0;  // rays that ended on a front; of two-sided polygons on either side
};

class EmbreeRivals {
 public:
  //   Throws: Error bad_input where a polygon is neither triangle nor parallelogram.
  EmbreeRivals(const Scene& scene, const Ids& ids);
  ~EmbreeRivals();

  // Counts lines: finds all hits of the lattice's lines along every direction, sorts them, and classifies every gap by
  // shaders/facing.h. The lattice is viewpeel's, up to rounding in 32-bit floats, without lines outside the unit ball.
  // Returns the number of facing pairs.
  uint64_t countLines(Trace trace, std::span<const Direction> directions, int resolution);

  // Shoots rays from uniform points on all polygons in turn, 64 from each, by Lambert's cosine law. Counts the first
  // polygon that each hits.
  RayCount shootRays(Trace trace, uint64_t ray_count, uint64_t seed);

  // Returns the counts of lines and rays since the last call, in the order of pairs.
  PairCounts takeCounts();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace viewpeel::bench
