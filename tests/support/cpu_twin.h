// The CPU twin is a second writing of the engines' rules, slow and plain. Every engine must have its counts.
#pragma once
#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// Tests plant these faults in the twin, and comparisons must find them.
enum class Fault { none, last_layer_dropped, two_depths_swapped };

// Returns the counts that every engine must have, to the last bit. It has the raster rules of shaders/geometry.glsl and
// project.comp and the facing rules, but none of the engines' passes. At every lattice point of the window it sorts all
// polygons that cover the point. With `blocked` it also counts blocked pairs.
PairCounts countPairsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions, int resolution,
                           bool blocked = false, Fault fault = Fault::none, const Window& window = {});

// Returns the counts by scanlines. In every interval between consecutive span ends it sorts all polygons that cover the
// middle.
PairCounts countIntervalsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions,
                               int resolution, bool blocked = false);

// Returns the counts that an engine has that does not count blocked pairs.
inline PairCounts withoutBlocked(PairCounts counts) {
  for (PairCount& c : counts) c.blocked = 0;
  std::erase_if(counts, [](const PairCount& c) { return c.count == 0; });
  return counts;
}

}  // namespace viewpeel
