// These factories make the engines that count on a lattice, by their kind.
#pragma once
#include <memory>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "vulkan/device.h"

namespace viewpeel {

// Returns a function that makes engines of one kind.
//   In: kind: compute, graphics or host; device: the device of the first two kinds, which the caller keeps alive;
//     nullptr for the host engine
EngineFactory latticeEngines(EngineKind kind, const Device* device);

// Makes one engine for all size groups: with one group an engine at its resolution, with more what makeGroupedEngine
// makes.
std::unique_ptr<Engine> makeEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                   LatticeOptions options, const std::vector<SizeGroup>& groups);

}  // namespace viewpeel
