// These factories make the engines that count lattice points, by kind.
#pragma once
#include <memory>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "engines/size_groups.h"
#include "vulkan/device.h"

namespace viewpeel {

// Makes engines of that kind.
//   In: kind: compute, graphics or host; device: of the first two, referred to; nullptr with the host engine
EngineFactory latticeEngines(EngineKind kind, const Device* device);

// Makes one engine for all groups: a plain one at the group's resolution where there is one group, else as
// makeGroupedEngine.
std::unique_ptr<Engine> makeEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                   LatticeOptions options, const std::vector<SizeGroup>& groups);

}  // namespace viewpeel
