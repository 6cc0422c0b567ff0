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
  command->add_option("--flip", options.flip, "Turn this surface or face over; may be given several times")->type_name("NAME")->allow_extra_args(false);
  command->add_flag("--fix-normals", options.fix_normals, "Turn faces over that look another way than most of their shell, and shells whose backs are seen instead of their fronts");
}

void addSettings(const SceneOptions& options, Settings& settings) {
  for (const std::string& name : options.sheets) settings.emplace_back("--sheets", name);
  for (const std::string& name : options.solids) settings.emplace_back("--solids", name);
  for (const std::string& name : options.flip) settings.emplace_back("--flip", name);
  if (options.fix_normals) settings.emplace_back("--fix-normals", "yes");
}

SceneOptions sceneOptionsOf(const Settings& settings) {
  SceneOptions options;
  for (const auto& [name, value] : settings) {
    if (name == "--sheets") options.sheets.push_back(value);
    if (name == "--solids") options.solids.push_back(value);
    if (name == "--flip") options.flip.push_back(value);
    if (name == "--fix-normals") options.fix_normals = value == "yes";
  }
  return options;
}

std::unique_ptr<Engine> makeLatticeEngine(EngineKind kind, const Device* device, const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  if (kind == EngineKind::host) return makeHostEngine(scene, ids, options);
  return kind == EngineKind::graphics ? makeGraphicsEngine(*device, scene, ids, options) : makeComputeEngine(*device, scene, ids, options);
}

}  // namespace viewpeel::program
