// Engine `compute`: depth peeling in compute shaders, tile by tile.
#pragma once
#include <memory>

#include "engines/engine.h"
#include "matrix/ids.h"
#include "vulkan/device.h"

namespace viewpeel {

struct ComputeOptions {
  int resolution = 64;            // lattice spacings across the unit ball's diameter, 1 to kMaxResolution
  bool two_sided = false;         // every polygon emits and receives on both sides
  uint32_t batch_directions = 0;  // directions peeled at once; 0 chooses by memory. Never changes the result.
  uint64_t counter_budget_bytes = 2ull << 30;
  uint32_t list_capacity = 0;     // first capacity of the tiles' lists; 0 chooses. It grows where needed and never changes the result.
};

// Counts lattice points, the same to the last bit as engine `graphics`.
//   Throws (constructor): Error limit where the dense counters of all pairs exceed the budget; Error device, also where the device's subgroups
//     have fewer than 8 or more than 64 invocations.
//   Cost: per direction, polygons x the tiles in their boxes, and lattice points x the length of their tile's list for every four layers.
std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const ComputeOptions& options);

}  // namespace viewpeel
