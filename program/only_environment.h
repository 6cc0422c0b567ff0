// `compute --only environment` gives one value a row, without a matrix; `--up` gives sky and ground apart.
#pragma once
#include <optional>

#include <viewpeel/environment.h>

#include "program/compute_options.h"

namespace viewpeel::program {

// Refuses options that only a matrix has.    Throws: Error bad_usage.
void checkOnlyEnvironment(const CLI::App* command, const ComputeOptions& options);

// Measures the environment of all rows, writes and prints it. Returns the exit status.
int computeOnlyEnvironment(const ComputeOptions& options);

// Splits the environment of a result into sky and ground, as exactly as the goal asks for the form factors.
//   Out: nothing without --up    Throws: as measureEnvironment.
std::optional<EnvironmentParts> splitEnvironmentOf(const ComputeOptions& options, const Scene& scene,
                                                   const Result& result, const Observer& observer);

// Says how much of all emitted radiation leaves upwards, and how much downwards.
std::string describeParts(const EnvironmentParts& parts);

}  // namespace viewpeel::program
