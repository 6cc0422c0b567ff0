// How the compute engine divides directions into batches, by the memory that they take. No division changes a result.
#pragma once
#include <cstdint>

#include "engines/lattice_options.h"
#include "vulkan/device.h"

namespace viewpeel {

constexpr uint32_t kGroupSize = 64;           // local_size_x of project, bin and allocate
constexpr uint64_t kMemoryBudget = 1u << 30;  // of all batches
constexpr uint32_t kTrialDirections = 4;      // after which the tuning is settled

// What one direction takes of a batch.
struct DirectionNeeds {
  uint64_t polygon_count, tile_count;
  uint64_t row_count;             // workgroups of peel
  uint64_t bytes;                 // of all its buffers but fragments
  uint64_t largest_buffer_bytes;  // of one of them
  uint64_t fragment_bytes;        // 0 where no polygon may enter itself
};

struct BatchPlan {
  uint32_t directions = 0;  // of a batch
  uint32_t in_flight = 2;   // batches at once
  bool enters = false;      // polygons over few lattice points enter themselves: for speed alone, where there is room for fragments
};

// In: fixed_bytes: what there is beside batches.
//   Throws: Error limit where one direction needs more memory, or more of what is counted, than the device has.
BatchPlan planBatches(const Device& device, const LatticeOptions& options, const DirectionNeeds& needs, uint64_t fixed_bytes);

// The options for a smaller plan, where the device had no memory for this one: half the directions, and last one batch at a time without fragments.
//   Out: false where that is what it was.
bool planSmaller(const BatchPlan& plan, LatticeOptions& options);

// That the device allows, read as texels of 8 bytes.
uint64_t largestBuffer(const Device& device);

}  // namespace viewpeel
