// Engine `compute`: depth peeling in compute shaders, tile by tile.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/device.h"

namespace viewpeel {

// Counts lattice points, the same to the last bit as engine `graphics`.
//   Throws (constructor): Error limit where the dense counters of all pairs exceed the budget; Error device, also where
//   the device's subgroups
//     have fewer than 8 or more than 64 invocations.
//   Cost: per direction, polygons x the tiles in their boxes, and lattice points x the length of their tile's list for
//   every four layers.
std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options);

}  // namespace viewpeel
