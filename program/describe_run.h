// What the program prints of a run: device and scene, plan, shares.
#pragma once
#include <string>

#include <viewpeel/compute.h>

namespace viewpeel::program {

// Device and scene.
std::string describePlace(const FormFactorRun& run, const Scene& scene);
// What a plan promises, and how to have the same run again; several lines.
std::string describePlan(const FormFactorRun& run);
std::string describePrior(const PriorSummary& prior);

}  // namespace viewpeel::program
