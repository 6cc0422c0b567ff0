// A batch plan divides the compute engine's directions into batches, by the memory that they take. No division changes
// a result.
#pragma once
#include <cstdint>

#include "engines/batch_buffers.h"
#include "engines/lattice_options.h"
#include "engines/tuning.h"
#include "vulkan/device.h"

namespace viewpeel {

constexpr uint32_t kGroupSize = 64;           // local_size_x of project, bin and allocate
constexpr uint64_t kMemoryBudget = 1u << 30;  // of all batches
constexpr uint32_t kTrialDirections = 4;      // after which the tuning is settled

// A BatchPlan says how batches are made.
struct BatchPlan {
  BatchShape shape;
  uint32_t in_flight = 2;  // batches at once
};

// A plan follows from these needs and the options.
struct BatchNeeds {
  uint32_t polygon_count;
  bool all_count;              // every polygon emits and receives
  uint32_t fragment_capacity;  // of a lattice point, if polygons over few of them enter themselves
  uint64_t fixed_bytes;        // of everything beside the batches
};

// Plans as many directions a batch as fit into memory and as outweigh a submission. Two batches are in flight where
// half of the memory holds one. Polygons enter themselves, for speed alone, where there is room for fragments.
//   Throws: Error limit where one direction needs more memory, or larger counters, than the device has.
BatchPlan planBatches(const Device& device, const LatticeOptions& options, const Tuning& tuning,
                      const BatchNeeds& needs);

// Sets the options for a smaller plan, where the device had no memory for this one: half the directions, and last one
// batch at a time without fragments.
//   Out: false where no smaller plan is left.
bool planSmaller(const BatchPlan& plan, LatticeOptions& options);

// That the device allows, read as texels of 8 bytes.
uint64_t largestBuffer(const Device& device);

}  // namespace viewpeel
