// What checkpoints know a run by.
#pragma once
#include <string>

#include <viewpeel/compute.h>

#include "run/setup.h"

namespace viewpeel {

// "6 polygons, fingerprint 0123456789abcdef".    Cost: O(corners).
std::string identityOf(const Scene& scene);

// How a scene was made, among settings, and back.
void addSettings(const SceneOptions& options, Settings& settings);
SceneOptions sceneOptionsOf(const Settings& settings);

// What decides about counts and is known before the plan.    Throws: Error bad_usage for medians.
Settings settingsOf(const Setup& setup);
// Whether a plan may choose the setting of that name.
bool mayBePlanned(const std::string& name);
// The same with what the plan chose.
Settings settingsOf(const Setup& setup, const PlanSummary& plan);

}  // namespace viewpeel
