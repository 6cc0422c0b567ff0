// The compute engine's passes are here: their kernels, and the order in which a batch of directions records them.
//   enter      where all polygons count: polygons over few lattice points become fragments, the others are listed
//   project    every polygon along every direction, or every listed one: snapped corners, box, depth over the lattice
//   bin emitters   where only some polygons count: tiles that emitters reach, and their span in each row of tiles
//   bin receivers  the same of the other receivers, within that span
//   bin count  counts the polygons that reach each tile
//   allocate   gives every tile its list and lists the active tiles
//   bin scatter  fills the lists
//   sort       where lines hit many polygons: orders the lists by depth
//   peel       every row of every active tile: spans of its polygons, samples, layers in order, facing rules, counters
//   cover      where blocked pairs are counted: lattice points of every active tile that each of its polygons covers
//   meet       counts how many of these points every two polygons of a tile share that may face each other
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

// A Batch of directions has these buffers, commands and plan.
struct Batch {
  Commands commands;
  Timestamps timestamps;                // a mark before the first pass and one after each
  std::vector<const char*> pass_names;  // of the passes that were recorded
  BatchShape shape;
  BatchBuffers buffers;
  std::span<const Direction> directions;
  uint64_t first_direction = 0;  // its number in the call
  bool in_flight = false;
};

// Ids decide these rules of the passes.
struct IdRules {
  explicit IdRules(const Ids& ids);

  bool two_sided, counts_environment;
  bool all_count;         // every polygon emits and receives
  bool are_indices;       // every polygon is its own id
  uint32_t needed_roles;  // of a tile that is worth peeling, 0 where all count
};

// The passes of all batches share these settings. They refer to objects of the engine.
struct PassSettings {
  const LatticeOptions& options;
  const Tuning& tuning;
  const SceneBuffers& scene;
  const PairCounters& counters;
  IdRules ids;
  int fraction_bits;  // of snapped coordinates
  int column_bits;    // of an edge's column coordinate

  bool isScanline() const { return options.sampling == Sampling::scanline; }
};

// Kernels without a use in the engine are not made.
struct PassKernels {
  Kernel enter, project, bin_emitters, bin_receivers, bin_count, allocate, bin_scatter, sort, peel, cover, meet;
};

PassKernels makeKernels(const Device& device, const PassSettings& settings, const BatchShape& shape);

// Records every pass over the batch's directions, which are in its buffer, and the copy of the batch's status to
// status_read.
void recordPasses(const PassSettings& settings, const PassKernels& kernels, Batch& batch);

// Records peel alone, over the tiles that the last dispatch left unfinished.
//   In: unfinished_count: of those tiles, at least 1
void recordResume(const PassSettings& settings, const PassKernels& kernels, Batch& batch, uint32_t unfinished_count);

}  // namespace viewpeel
