// This is a second writing of the engines' rules, slow and plain, whose counts every engine must equal.
#pragma once
#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// Tests plant these faults, which comparisons must notice.
enum class Fault { none, last_layer_dropped, two_depths_swapped };

// Returns the counts that an engine must have, to the last bit. It is a second writing of the raster rules of
// shaders/geometry.glsl and project.comp and of the facing rules, without any of the engines' passes. Every lattice
// point of the window sorts all polygons that cover it. With `blocked` every two of them are looked at.
PairCounts countPairsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions, int resolution,
                           bool blocked = false, Fault fault = Fault::none, const Window& window = {});

// Returns the same with scanlines: every interval between consecutive ends of spans sorts all polygons that hold its
// middle.
PairCounts countIntervalsOnCpu(const Scene& scene, const Ids& ids, const std::vector<Direction>& directions,
                               int resolution, bool blocked = false);

// Returns the counts of an engine that counts no blocked pairs.
inline PairCounts withoutBlocked(PairCounts counts) {
  for (PairCount& c : counts) c.blocked = 0;
  std::erase_if(counts, [](const PairCount& c) { return c.count == 0; });
  return counts;
}

}  // namespace viewpeel
