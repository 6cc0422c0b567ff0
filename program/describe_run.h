// The program prints these descriptions of a run: device and scene, plan, visibilities.
#pragma once
#include <string>

#include <viewpeel/compute.h>

namespace viewpeel::program {

// Describes device and scene.
std::string describePlace(const FormFactorRun& run, const Scene& scene);
// Describes a plan's promise, and the options for the same run again; several lines.
std::string describePlan(const FormFactorRun& run);
std::string describePrior(const PriorSummary& prior);

}  // namespace viewpeel::program
