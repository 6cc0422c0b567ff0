// This header has the options of the engines that count lattice points: the lattice itself, and the tuning that changes
// no result.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include <glm/vec3.hpp>

#include <viewpeel/sampling.h>

namespace viewpeel {

// A Window is the part of the scene whose projections are looked at: a ball that holds every polygon that emits.
struct Window {
  glm::dvec3 centre{0};  // unit-ball units
  double radius = 1;
};

// The engines that count lattice points have these options in common. None but `resolution`, `sampling`, `window` and
// `count_blocked` changes a result.
struct LatticeOptions {
  int resolution = 64;  // lattice spacings across the unit ball's diameter, 1 to kMaxResolution
  Sampling sampling = Sampling::lattice;
  Window window;               // of the compute engine; smaller than the scene it may have up to kMaxWindowResolution
  bool count_blocked = false;  // pairs, too: PairCount::blocked
  uint32_t batch_directions = 0;  // directions peeled at once; 0 chooses by memory
  uint64_t counter_budget_bytes =
      0;  // of the dense counters, beyond which the compute engine keeps a hash table; 0 chooses

  // The compute engine has these; 0 chooses. Tests set them to show that they do not matter.
  uint32_t tile_width = 0;             // lattice columns; 32 with scanlines
  uint32_t tile_rows = 0;              // 1 to 8
  uint32_t layers_kept = 0;            // a round
  std::optional<uint32_t> few_points;  // a polygon over no more lattice points, in a box of at most 8 x 8, enters
                                       // itself at each; 0: none does
  uint32_t fragment_capacity = 0;      // of a lattice point at first: layers that entered themselves
  bool sort = false;                   // lists of tiles by depth
  bool aggregate = true;               // contributions of neighbouring samples before they are added
  uint32_t list_capacity = 0;          // of the tile lists at first
  uint32_t table_capacity = 0;         // of the hash table at first
  uint32_t most_blocks = 0;            // of spans that one invocation of peel goes through
  uint64_t memory_budget_bytes = 0;    // of batches; a direction that needs more gets it, and one batch at a time
  uint64_t available_bytes = 0;        // on the device; an engine that needs more is refused
  bool measure_work = false;
  uint32_t thread_count = 0;  // of the host engine; 0: one per core
  // Engines that finish directions on several threads call it before each, from any thread. An exception from it ends
  // the call. It may be empty.
  std::function<void()> stop;
  // The engine calls it with the number of directions of a call that have been counted. An exception from it ends the
  // call. It may be empty.
  std::function<void(uint64_t directions)> on_batch;
};

}  // namespace viewpeel
