// A checkpoint recognises its run by these settings.
#pragma once
#include <string>

#include <viewpeel/compute.h>

#include "run/setup.h"

namespace viewpeel {

// Returns the scene in words: "6 polygons, fingerprint 0123456789abcdef".    Cost: O(corners).
std::string identityOf(const Scene& scene);

// Adds to the settings how a scene was made, and reads it back.
void addSettings(const SceneOptions& options, Settings& settings);
SceneOptions sceneOptionsOf(const Settings& settings);

// Returns the settings that decide about counts and are settled before the plan.    Throws: Error bad_usage for
// medians.
Settings settingsOf(const Setup& setup);
// Returns whether a plan may choose the setting of that name.
bool mayBePlanned(const std::string& name);
// Returns all settings, with the plan's choices.
Settings settingsOf(const Setup& setup, const PlanSummary& plan);

}  // namespace viewpeel
