// Engine `compute` peels by depth in compute shaders, tile by tile.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>
#include "vulkan/device.h"

namespace viewpeel {

// Makes an engine that counts lattice points or scanlines: the same counts, to the last bit, as engines `graphics`
// (lattice points) and `host`.
//   In: device: the caller keeps it alive
//   Throws: Error bad_usage where the resolution is out of range, or too fine for scanlines; Error limit where one
//     direction does not fit the device's memory; Error device, also where the device's subgroups have fewer than 8 or
//     more than 64 invocations.
//   Cost: per direction, polygons x the tiles in their boxes, and, for every four layers, lattice points x the length
//     of their tile's list.
std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids,
                                          const LatticeOptions& options);

}  // namespace viewpeel
