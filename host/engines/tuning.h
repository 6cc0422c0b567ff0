// A Tuning has the sizes that the compute engine chooses by device, scene and options. None of them changes a result.
#pragma once
#include <cstdint>

#include "engines/lattice_options.h"
#include <viewpeel/scene.h>
#include "vulkan/device.h"

namespace viewpeel {

namespace device_data {
struct BatchStatus;
}

// Options of the same names are in LatticeOptions. `steps` is the number of samples of an invocation of peel.
struct Tuning {
  uint32_t subgroup_size, tile_width, tile_rows, steps, layers_kept, most_blocks;
  bool sorts;
};

// Returns the values that the options give, and the best values for the device where options are 0.
//   Throws: Error device where the device's subgroups have no shuffles, or fewer than 8 or more than 64 invocations.
Tuning tune(const Device& device, const LatticeOptions& options);

// Sets options that the caller left at 0, by the status of the first batch, which must have an active tile.
void adaptOptions(const device_data::BatchStatus& found, LatticeOptions& options);

// Returns how many bytes dense counters may take; beyond them the engine has a hash table.
uint64_t counterBudget(const LatticeOptions& options);

// Returns LatticeOptions::few_points for a scene: 0 where it is better that no polygon becomes fragments.
uint32_t chooseFewPoints(const Scene& scene, int resolution);

}  // namespace viewpeel
