#include "cli/options.h"

#include "engines/compute_engine.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"

namespace viewpeel::cli {

std::unique_ptr<Engine> makeLatticeEngine(EngineKind kind, const Device* device, const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  if (kind == EngineKind::host) return makeHostEngine(scene, ids, options);
  return kind == EngineKind::graphics ? makeGraphicsEngine(*device, scene, ids, options) : makeComputeEngine(*device, scene, ids, options);
}

}  // namespace viewpeel::cli
