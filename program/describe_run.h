// These functions describe a run for the program's output: device and scene, plan, prior.
#pragma once
#include <string>

#include <viewpeel/compute.h>

namespace viewpeel::program {

// Describes the device that counts, or the processor, and the scene.
std::string describePlace(const FormFactorRun& run, const Scene& scene);
// Describes a plan: what it promises, and options that repeat the same run; several lines.
std::string describePlan(const FormFactorRun& run);
// Describes what a promise would take by other bounds; empty where the plan has none.
std::string describeAlternatives(const PlanSummary& plan);
// Describes the unoccluded form factors and pilots of a run, and how many pairs get directions of their own.
std::string describePrior(const PriorSummary& prior);

}  // namespace viewpeel::program
