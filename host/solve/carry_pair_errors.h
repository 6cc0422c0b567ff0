// carryPairErrors() carries the errors of form factors to solutions with bands of wavelengths, in first order.
#pragma once
#include "solve/band_errors.h"
#include "solve/band_system.h"

namespace viewpeel {

constexpr size_t kMostSources = 512;

// Returns a column for each pair's error, or kProbes columns (heat_errors.h), each for random signs of all errors,
// where there are too many. Columns for errors of sky and ground come last. Derivation: docs/solve.md, eq. (7), (8) and
// (13).
//   In: system: after solve(); most_sources: with more errors of exchange areas there are probes
//   Error: of first order; with probes, 1/16 of the standard error. Tests: tests/unit/solve_errors_test.cpp.
//   Cost: BandSystem::respond for each column.
BandErrors carryPairErrors(const FormFactors& measured, const ClosedExchange& closed, const BandSystem& system,
                           size_t most_sources = kMostSources);

}  // namespace viewpeel
