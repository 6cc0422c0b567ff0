// Engine `host`: on the processor's own threads.
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

// The samples with which it has the smaller error after the same time (bench/sampling_error): scanlines in scenes of
// few polygons, lattice points in those of many, whose polygons are so small that a scanline is worth few points; also
// where polygons are too small for scanlines, which windows can make less fine.
//   In: has_prior: of unoccluded form factors, by polygon (VisibilitySums); these need the more lines the smaller
//   polygons are
Sampling chooseSampling(const Scene& scene, const Ids& ids, bool has_prior);

}  // namespace viewpeel
