// These functions write the program's summaries.
#pragma once
#include <string>

#include "engines/work.h"
#include "estimator/estimate.h"
#include <viewpeel/balance.h>
#include "vulkan/device.h"

namespace viewpeel::program {

std::string describeDevice(const DeviceDescription& device);
// Describes the processor of the host engine.
std::string describeProcessor();

// Returns a count with its noun: "1 polygon", "2 polygons".
std::string counted(uint64_t count, const char* noun);

// Describes polygons, surfaces, areas, and whether the scene is closed; several lines.
std::string describeScene(const Scene& scene);
// Describes pairs of coincident polygons and their order; empty where there are none.
std::string describeCoincidences(const Scene& scene);

// Returns a table of the largest form factors between surfaces, with standard errors.
std::string tabulateLargest(const FormFactors& between_surfaces, size_t rows);

// Returns text for the line `work`, which follows the number of common directions: how many lines the pairs had, or how
// many directions the directed pairs had. The text is empty if there were neither lines nor directed pairs.
std::string describeDirected(const Estimate& estimate);
// Returns how many common directions a run has counted, or how many rays a polygon has in a
// replicate.
std::string describeDirections(const Estimate& estimate, bool has_rays);

// Returns the largest form factors and describeErrors().
std::string describeResult(const Estimate& estimate);

// Describes standard errors, closure, leak and environment of the whole matrix.
std::string describeErrors(const Estimate& estimate);

// Describes how balancing changed the form factors.
std::string describeBalance(const BalancedFormFactors& balanced);

// A message of the validation layer shows an error of the program: this function then refuses any result.
//   Throws: Error device.
void checkValidation(const Device& device);

}  // namespace viewpeel::program
