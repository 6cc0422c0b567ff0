// Engine `graphics` is depth peeling on the raster pipeline (Everitt 2001), one pass per layer.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/device.h"

namespace viewpeel {

// Counts lattice points: unitArea() is the square of the spacing h = 2 / resolution.
//   Throws (constructor): Error limit where the dense counters of all pairs exceed the budget; Error device.
//   Cost: per direction, layers x polygons vertices, plus the lattice points of every polygon's box in every layer.
std::unique_ptr<Engine> makeGraphicsEngine(const Device& device, const Scene& scene, const Ids& ids,
                                           const LatticeOptions& options);

}  // namespace viewpeel
