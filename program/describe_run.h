// These functions describe a run for the program's output: device and scene, plan, visibilities.
#pragma once
#include <string>

#include <viewpeel/compute.h>

namespace viewpeel::program {

// Describes device and scene.
std::string describePlace(const FormFactorRun& run, const Scene& scene);
// Describes a plan: what it promises, and options that repeat the same run; several lines.
std::string describePlan(const FormFactorRun& run);
std::string describePrior(const PriorSummary& prior);

}  // namespace viewpeel::program
