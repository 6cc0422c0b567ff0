// Work that an engine did, counted, where LatticeOptions::measure_work asks for it.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace viewpeel {

struct Work {
  uint64_t directions = 0;
  uint64_t lattice_points = 0;  // of the tiles, or with scanlines their rows, that hold anything
  uint64_t tiles = 0;           // in all windows
  uint64_t active_tiles = 0;    // of the compute engine with scanlines, parts of tiles
  uint64_t list_entries = 0;    // polygons in tiles
  uint64_t rows = 0;            // of tiles, that hold a span
  uint64_t spans = 0;           // polygons in rows
  uint64_t samples = 0;         // lattice points or intervals peeled
  uint64_t rounds = 0;          // over the samples of one subgroup
  uint64_t tests = 0;           // of a sample against a span
  uint64_t fragments = 0;       // samples that a span covers: layers
  uint64_t gaps = 0;            // between consecutive layers, counted ones: facing pairs, environment and leak
  uint64_t repeats = 0;         // batches done again because something had to grow
  uint64_t resumed = 0;         // dispatches that went on with unfinished tiles
  uint64_t memory_bytes = 0;    // on the device
  std::vector<std::pair<std::string, double>> pass_seconds;
};

// Of engines, or threads, that take the same directions.
void addWork(const Work& part, Work& sum);

}  // namespace viewpeel
