// The compute engine records these passes for a batch of directions, in this order:
//   enter          makes fragments of polygons over few lattice points, and lists the others
//   project        finds snapped corners, box and depth over the lattice of every polygon, or of every listed one
//   bin emitters   finds the tiles that emitters reach, and the first and last of them in each row of tiles
//   bin receivers  finds the tiles between these two that receivers reach
//   bin count      counts the polygons that reach each tile
//   allocate       gives every tile room for its list, and lists the active tiles
//   bin scatter    writes the lists
//   sort           sorts the lists by depth
//   peel           finds the layers of every sample in order, and counts the gaps between them
//   cover          finds which lattice points of an active tile each of its polygons covers
//   meet           counts, for every two polygons of a tile, the lattice points on which their fronts look at each
//     other
// Enter needs lattice points, and all polygons to count. Bin emitters and receivers run where only some polygons count;
// sort where lines meet many polygons; cover and meet where blocked pairs are counted on lattice points.
#pragma once
#include <span>
#include <vector>

#include <viewpeel/engine.h>
#include "engines/batch_buffers.h"
#include "engines/lattice.h"
#include "engines/pair_counters.h"
#include "engines/tuning.h"
#include "vulkan/commands.h"
#include "vulkan/timestamps.h"

namespace viewpeel {

constexpr size_t kMostPasses = 11;

// A Batch is a number of directions that the device counts in one submission, with its buffers and commands.
struct Batch {
  Commands commands;
  Timestamps timestamps;                // one before the first pass, and one after each pass
  std::vector<const char*> pass_names;  // names of the recorded passes
  BatchShape shape;
  BatchBuffers buffers;
  std::span<const Direction> directions;
  uint64_t first_direction = 0;  // number of the batch's first direction within the call
  bool in_flight = false;        // whether the device may still work on it
};

// IdRules are the variants of the passes that follow from the ids.
struct IdRules {
  explicit IdRules(const Ids& ids);

  bool two_sided, counts_environment;
  bool all_count;         // every polygon emits and receives
  bool are_indices;       // every polygon is its own id
  uint32_t needed_roles;  // a tile is peeled only where its polygons together have these roles; 0 where all count
};

// PassSettings are the settings that the passes of all batches share. The engine keeps the objects alive.
struct PassSettings {
  const LatticeOptions& options;
  const Tuning& tuning;
  const SceneBuffers& scene;
  const PairCounters& counters;
  IdRules ids;
  int fraction_bits;  // binary digits after the point of snapped coordinates
  int column_bits;    // columns are in units of 2^-column_bits spacings

  bool isScanline() const { return options.sampling == Sampling::scanline; }
};

// PassKernels are the kernels of the passes.
struct PassKernels {
  Kernel enter, project, bin_emitters, bin_receivers, bin_count, allocate, bin_scatter, sort, peel, cover, meet;
};

// Makes the kernels of the passes that batches of this shape have; the other kernels stay empty.
PassKernels makeKernels(const Device& device, const PassSettings& settings, const BatchShape& shape);

// Records all passes of a batch, and the copy of its status to status_read. The directions must be in their buffer.
void recordPasses(const PassSettings& settings, const PassKernels& kernels, Batch& batch);

// Records the pass peel alone, over the tiles that its last dispatch left unfinished.
//   In: unfinished_count: number of these tiles, at least 1
void recordResume(const PassSettings& settings, const PassKernels& kernels, Batch& batch, uint32_t unfinished_count);

}  // namespace viewpeel
