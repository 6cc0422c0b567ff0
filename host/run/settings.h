// Settings are the options that change counts, as text. By them a checkpoint recognises the run it belongs to.
#pragma once
#include <string>

#include <viewpeel/compute.h>

#include "run/setup.h"

namespace viewpeel {

// Returns the scene's size and fingerprint: "6 polygons, fingerprint 0123456789abcdef".    Cost: O(corners).
std::string identityOf(const Scene& scene);

// Adds the options by which the scene was made to the settings. The second function reads them back.
void addSettings(const SceneOptions& options, Settings& settings);
SceneOptions sceneOptionsOf(const Settings& settings);

// Returns the settings that change counts and are known before the plan.    Throws: Error bad_usage for medians, which
// checkpoints do not keep.
Settings settingsOf(const Setup& setup);
// Returns whether a plan may choose the setting with this name.
bool mayBePlanned(const std::string& name);
// Returns all settings, also the ones that the plan has chosen.
Settings settingsOf(const Setup& setup, const PlanSummary& plan);

}  // namespace viewpeel
