// Engine `graphics` peels by depth on the raster pipeline, one draw a layer (C. Everitt, Interactive order-independent
// transparency, 2001).
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/device.h"

namespace viewpeel {

// Makes an engine that counts lattice points; its unitArea() is the square of the spacing h = 2 / resolution.
//   In: device: the caller keeps it alive
//   Throws: Error limit where the dense counters of all pairs exceed the budget; Error bad_usage where the resolution
//     is out of range or more than two polygons coincide; Error device.
//   Cost: per direction and layer, four vertices a polygon, and the lattice points of every polygon's outline.
std::unique_ptr<Engine> makeGraphicsEngine(const Device& device, const Scene& scene, const Ids& ids,
                                           const LatticeOptions& options);

}  // namespace viewpeel
