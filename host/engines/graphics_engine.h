// Engine `graphics`: depth peeling on the raster pipeline (Everitt 2001), one pass per layer.
#pragma once
#include <memory>

#include "engines/engine.h"
#include "matrix/ids.h"
#include "vulkan/device.h"

namespace viewpeel {

struct GraphicsOptions {
  int resolution = 64;            // lattice spacings across the unit ball's diameter, 1 to kMaxResolution
  bool two_sided = false;         // every polygon emits and receives on both sides
  uint32_t batch_directions = 0;  // directions peeled side by side; 0 chooses by memory. Never changes the result.
  uint64_t counter_budget_bytes = 2ull << 30;
};

constexpr int kMaxResolution = 4096;

// Counts lattice points: unitArea() is the square of the spacing h = 2 / resolution.
//   Throws (constructor): Error limit where the dense counters of all pairs exceed the budget; Error device.
//   Cost: per direction, layers x polygons vertices, plus the lattice points of every polygon's box in every layer.
std::unique_ptr<Engine> makeGraphicsEngine(const Device& device, const Scene& scene, const Ids& ids, const GraphicsOptions& options);

}  // namespace viewpeel
