// planBatches divides the compute engine's directions into batches that fit the device's memory. No division changes a
// result.
#pragma once
#include <cstdint>

#include "engines/batch_buffers.h"
#include "engines/lattice_options.h"
#include "engines/tuning.h"
#include "vulkan/device.h"

namespace viewpeel {

constexpr uint32_t kGroupSize = 64;           // local_size_x of project, bin and allocate
constexpr uint64_t kMemoryBudget = 1u << 30;  // memory of all batches in flight, unless options say otherwise
constexpr uint32_t kTrialDirections = 4;      // directions of the first batch, from which the tuning is chosen

// A BatchPlan is the shape of all batches, and how many of them the device works on at once.
struct BatchPlan {
  BatchShape shape;
  uint32_t in_flight = 2;
};

// BatchNeeds are the numbers, beside options and tuning, from which a plan follows.
struct BatchNeeds {
  uint32_t polygon_count;
  bool all_count;              // every polygon emits and receives
  uint32_t fragment_capacity;  // most fragments of a lattice point, where polygons become fragments
  uint64_t fixed_bytes;        // memory of the scene and the counters
};

// Plans how many directions a batch has: as many as fit the memory, but no more than make the cost of a submission
// small. Two batches are in flight where half of the memory holds one. Polygons over few lattice points become
// fragments where there is room for them; this only saves time.
//   Throws: Error limit where one direction needs more memory, polygons or tiles than the device has or can address.
BatchPlan planBatches(const Device& device, const LatticeOptions& options, const Tuning& tuning,
                      const BatchNeeds& needs);

// Changes the options so that the next plan needs less memory than this one, for which the device had no room. It
// halves the directions of a batch; from one direction on it allows only one batch at a time, without fragments.
//   Out: false where no smaller plan is left.
bool planSmaller(const BatchPlan& plan, LatticeOptions& options);

// Returns the size, in bytes, of the largest buffer that the device allows and can read as texels of 8 bytes.
uint64_t largestBuffer(const Device& device);

}  // namespace viewpeel
