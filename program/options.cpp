#include "program/options.h"

#include "engines/compute_engine.h"
#include "engines/graphics_engine.h"
#include "engines/host_engine.h"

namespace viewpeel::program {

void addSceneOptions(CLI::App* command, SceneOptions& options) {
  command->add_option("--sheets", options.sheets, "Coincident faces of this surface are a thin sheet, back to back, whatever lies around; may be given several times")
      ->type_name("NAME")->allow_extra_args(false);
  command->add_option("--solids", options.solids, "Coincident faces of this surface are of touching solids, face to face, whatever lies around; may be given several times")
      ->type_name("NAME")->allow_extra_args(false);
}

std::unique_ptr<Engine> makeLatticeEngine(EngineKind kind, const Device* device, const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  if (kind == EngineKind::host) return makeHostEngine(scene, ids, options);
  return kind == EngineKind::graphics ? makeGraphicsEngine(*device, scene, ids, options) : makeComputeEngine(*device, scene, ids, options);
}

}  // namespace viewpeel::program
