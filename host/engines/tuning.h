// The compute engine chooses these values by device, scene and options. None of them changes a result.
#pragma once
#include <cstdint>

#include "engines/lattice_options.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel {

namespace device_data {
struct BatchStatus;
}

struct Tuning {
  uint32_t subgroup_size, tile_width, tile_rows, steps, layers_kept, most_blocks;
  bool sorts;
};

// Takes the options' values, or the best for the device.
//   Throws: Error device where its subgroups are of no use.
Tuning tune(const Device& device, const LatticeOptions& options);

// Chooses open options by the first batch's figures over its active tiles, of which there is at least one.
void adaptOptions(const device_data::BatchStatus& found, LatticeOptions& options);

// Returns the budget of dense counters, beyond which they are kept in a hash table.
uint64_t counterBudget(const LatticeOptions& options);

// Returns the most lattice points of a polygon that enters itself, see LatticeOptions; 0 where none should.
uint32_t chooseFewPoints(const Scene& scene, int resolution);

}  // namespace viewpeel
