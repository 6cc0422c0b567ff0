// Engine `host` counts on the processor's threads.
#pragma once
#include <memory>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include <viewpeel/ids.h>

namespace viewpeel {

// Makes an engine that counts lattice points or scanlines: the same counts, to the last bit, as engine `compute`. It
// needs no Vulkan device.
//   In: options: it reads resolution, sampling, window, count_blocked, counter_budget_bytes (of each thread's dense
//     counters), thread_count, available_bytes, measure_work and on_batch
//   Throws: Error bad_usage where the resolution is out of range; Error limit where one thread's work does not fit the
//     memory.
//   Cost: a direction takes one thread as long as Sweep::count says.
std::unique_ptr<Engine> makeHostEngine(const Scene& scene, const Ids& ids, const LatticeOptions& options);

// Chooses the samples that give the smaller error after the same time (bench/programs/sampling_error.cpp). Scanlines do
// in scenes of few polygons. Lattice points do in scenes of many polygons, which are so small that a scanline is worth
// few points. Where a row's area is below 1e-10 lattice points are chosen, too, for windows of scanlines cannot be as
// fine. So they are where polygons pass through each other, for scanlines cannot order these.
//   In: has_prior: whether unoccluded form factors by polygon are at hand (VisibilitySums); scanlines then pay in
//     scenes of more polygons
Sampling chooseSampling(const Scene& scene, const Ids& ids, bool has_prior);

// Chooses the resolution of a lattice from which only sums of rows are wanted, not pairs.
//   In: spacings_per_side: spacings along the side of a square of the polygons' median area; finest: the largest
//     resolution wanted    Out: 64 to finest    Cost: O(polygons).
int chooseResolution(const Scene& scene, double spacings_per_side, int finest);

}  // namespace viewpeel
