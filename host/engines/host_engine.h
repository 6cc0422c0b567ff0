// Engine `host` runs on the processor's own threads.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>

namespace viewpeel {

// Counts lattice points or scanlines, the same to the last bit as engine `compute`. Needs no Vulkan device.
//   In: of the options resolution, sampling, window, count_blocked, counter_budget_bytes (of each thread's dense
//   counters), thread_count, available_bytes,
//     measure_work and on_batch
//   Throws (constructor): Error bad_usage where the resolution is out of range; Error limit where one thread's work
//   does not fit the memory.
//   Cost: per direction and thread as Sweep.
std::unique_ptr<Engine> makeHostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

// Chooses the samples with the smaller error after the same time (bench/programs/sampling_error.cpp). It takes
// scanlines in scenes of few polygons, and lattice points in scenes of many, whose polygons are so small that a
// scanline is worth few points. Lattice points also serve polygons that are too small for scanlines, whose windows
// cannot be as fine.
//   In: has_prior: of unoccluded form factors, by polygon (VisibilitySums). These need the more lines the smaller
//     polygons are.
Sampling chooseSampling(const Scene& scene, const Ids& ids, bool has_prior);

}  // namespace viewpeel
