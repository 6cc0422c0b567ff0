// These functions turn results, plans and devices into JSON.
#pragma once
#include <vector>

#include <viewpeel/compute.h>
#include <viewpeel/solve.h>

#include "program/json.h"
#include "reference/exact/lattice_check.h"
#include "vulkan/device.h"

namespace viewpeel::program {

// Adds the scene: file, numbers of polygons and surfaces, area, radius, and whether it is closed.
void addScene(Json& report, const Scene& scene);
// Adds the estimate's errors, closure, shares and counts, but not its matrix.
void addEstimate(Json& report, const Estimate& estimate);
// Adds the estimate in the same way, and plan, balancing and work.
void addResult(Json& report, const Result& result);
// Adds the answers of solve, row by row.
void addHeat(Json& report, const HeatSolution& solution, By by);

Json jsonOf(const PlanSummary& plan);
Json jsonOf(const DeviceDescription& device);
Json jsonOf(const reference::CheckReport& report);

}  // namespace viewpeel::program
