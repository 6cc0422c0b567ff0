#include "engines/engine_factory.h"

#include "engines/compute_engine.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"

namespace viewpeel {

EngineFactory latticeEngines(EngineKind kind, const Device* device) {
  if (kind == EngineKind::host) return makeHostEngine;
  return [device, make = kind == EngineKind::graphics ? makeGraphicsEngine : makeComputeEngine](
             const Scene& scene, const Ids& ids, const LatticeOptions& options) {
    return make(*device, scene, ids, options);
  };
}

std::unique_ptr<Engine> makeEngine(const EngineFactory& make_engine, const Scene& scene, const Ids& ids,
                                   LatticeOptions options, const std::vector<SizeGroup>& groups) {
  options.resolution = groups[0].resolution;
  return groups.size() > 1 ? makeGroupedEngine(make_engine, scene, ids, options, groups)
                           : make_engine(scene, ids, options);
}

}  // namespace viewpeel
