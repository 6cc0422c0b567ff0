// Engine `exact`: the estimator on exact pair areas.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include <viewpeel/ids.h>
#include "reference/exact/exact_pair_areas.h"

namespace viewpeel::reference {

// Areas in units of 2^-40, rounded to the nearest: the sum over directions is an integer, whatever the number of
// threads.
//   In: options: thread_count, on_direction and blocked; the others are the engine's own
//   Error: 2^-41 unit-ball units squared per pair and direction, plus computeExactPairAreas's.
//   Throws (constructor): Error bad_input where polygons pass through each other, naming two and the place.
//   Cost: computeExactPairAreas per direction, over `thread_count` threads.
std::unique_ptr<Engine> makeExactEngine(const Scene& scene, const Ids& ids, const ExactOptions& options = {});

// Engines of this kind for what takes engines of any. Of the options of lattices thread_count, count_blocked and stop
// are looked at.
EngineFactory exactEngines();

}  // namespace viewpeel::reference
