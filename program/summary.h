// The program prints these summaries for people.
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

// Describes polygons, surfaces, areas, closed or open; several lines.
std::string describeScene(const Scene& scene);
// Describes pairs of coincident polygons and how they are ordered; empty where there are none.
std::string describeCoincidences(const Scene& scene);

// Tabulates the largest form factors between named surfaces, with standard errors.
std::string tabulateLargest(const FormFactors& between_surfaces, size_t rows);

// Describes directions of pairs that have their own, after the number of common ones; empty where there are none.
std::string describeDirected(const Estimate& estimate);

// Joins the largest form factors and describeErrors.
std::string describeResult(const Estimate& estimate);

// Describes standard errors, closure, leak and environment of the whole matrix.
std::string describeErrors(const Estimate& estimate);

// Describes the changes by balancing.
std::string describeBalance(const BalancedFormFactors& balanced);

// Messages of the validation layer are our errors: there is never a result beside them.
//   Throws: Error device.
void checkValidation(const Device& device);

}  // namespace viewpeel::program
