// Engine `exact` computes exact pair areas instead of counting lattice points.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include <viewpeel/ids.h>
#include "reference/exact/exact_pair_areas.h"

namespace viewpeel::reference {

// Makes an engine whose areas are in units of 2^-40, rounded to the nearest. The sum over directions is an integer,
// whatever the number of threads.
//   In: options: thread_count, on_direction and blocked; the engine sets the others
//   Error: 2^-41 unit-ball units squared per pair and direction, plus the error of computeExactPairAreas.
//   Throws (constructor): Error bad_input where polygons pass through each other, naming two of them and the place.
//   Cost: computeExactPairAreas per direction, over `thread_count` threads.
std::unique_ptr<Engine> makeExactEngine(const Scene& scene, const Ids& ids, const ExactOptions& options = {});

// Returns a factory of these engines, for users of any engine. It takes thread_count, count_blocked and stop from the
// options of lattices.
EngineFactory exactEngines();

}  // namespace viewpeel::reference
