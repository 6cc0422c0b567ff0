// The engines that count on a lattice have these options: the lattice itself, and tuning, which changes no result.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include <glm/vec3.hpp>

#include <viewpeel/sampling.h>

namespace viewpeel {

// A Window is the part of the scene over which a lattice is laid: a ball that holds every polygon that emits.
struct Window {
  glm::dvec3 centre{0};  // unit-ball units
  double radius = 1;
};

// LatticeOptions are the options of all engines that count on a lattice. Only `resolution`, `sampling`, `window`,
// `count_blocked` and `split_environment` change a result.
struct LatticeOptions {
  int resolution = 64;  // lattice spacings across the unit ball's diameter, 1 to kMaxResolution
  Sampling sampling = Sampling::lattice;
  Window window;               // a window smaller than the scene allows resolutions up to kMaxWindowResolution
  bool count_blocked = false;  // whether blocked pairs are counted, too: PairCount::blocked
  // Where it is true, the host engine counts lines that leave the scene along u for kEnvironment, and along -u for
  // kLeak. Lines that end on backs then count for nothing.
  bool split_environment = false;
  uint32_t batch_directions = 0;  // directions of a batch; 0: chosen by memory
  // Dense counters take at most this number of bytes; 0: the engine chooses. Where they would take more, the compute
  // and host engines have hash tables.
  uint64_t counter_budget_bytes = 0;

  // The compute engine chooses these where they are 0. Tests set them to show that they do not change a result.
  uint32_t tile_width = 0;   // lattice columns; always 32 with scanlines
  uint32_t tile_rows = 0;    // lattice rows, 1 to 8
  uint32_t layers_kept = 0;  // layers of a sample that peel keeps in registers in each round
  // A polygon becomes fragments where its box holds at most this many lattice points and is at most 8 x 8. 0: no
  // polygon does; without a value the engine chooses.
  std::optional<uint32_t> few_points;
  uint32_t fragment_capacity = 0;  // fragments of a lattice point for which there is room at first
  bool sort = false;               // whether lists of tiles are sorted by depth
  bool aggregate = true;           // whether equal pairs of neighbouring samples are joined before they are added
  uint32_t list_capacity = 0;      // entries for which all tiles' lists have room at first
  uint32_t table_capacity = 0;     // places of the hash table at first
  uint32_t most_blocks = 0;        // blocks of polygons that one invocation of peel goes through
  // All batches in flight together take at most this memory; 0: the engine chooses. A single direction that needs more
  // gets it, one batch at a time.
  uint64_t memory_budget_bytes = 0;
  uint64_t available_bytes = 0;  // memory of the device, or of the machine; an engine that needs more is refused
  bool measure_work = false;     // whether Engine::work() counts work
  uint32_t thread_count = 0;     // threads of the host engine; 0: one a core
  // Engines that finish directions on several threads call this function before each direction, from any thread. An
  // exception from it ends the call. It may be empty.
  std::function<void()> stop;
  // Engines call this function with the number of directions that they have counted in the present call. An exception
  // from it ends the call. It may be empty.
  std::function<void(uint64_t directions)> on_batch;
};

}  // namespace viewpeel
