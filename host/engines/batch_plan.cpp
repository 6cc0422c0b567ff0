#include "engines/batch_plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "engines/lattice.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint64_t kBatchWork = 1u << 17;  // polygons, or tiles: enough to outweigh a submission

}  // namespace

BatchPlan planBatches(const Device& device, const LatticeOptions& options, const DirectionNeeds& needs, uint64_t fixed_bytes) {
  const VkPhysicalDeviceLimits& limits = device.properties().limits;
  const uint64_t available = options.available_bytes ? options.available_bytes : device.memoryBytes();
  if (fixed_bytes + needs.bytes > available)
    throw Error(ErrorCode::limit, fmt::format("{} polygons at resolution {} need {:.0f} MiB, {} has {:.0f} MiB; try a smaller --resolution or scene, or --by surface",
                                              needs.polygon_count, options.resolution, double(fixed_bytes + needs.bytes) / 1048576.0,
                                              device.description().name, double(available) / 1048576.0));
  if (divideUp(needs.polygon_count, kGroupSize) > limits.maxComputeWorkGroupCount[0])
    throw Error(ErrorCode::limit, fmt::format("{} polygons are more than {} can be asked to project at once; try a smaller scene", needs.polygon_count,
                                              device.description().name));
  const uint64_t budget = std::min<uint64_t>(options.memory_budget_bytes ? options.memory_budget_bytes : kMemoryBudget, available - fixed_bytes) / 2;
  const uint64_t largest = largestBuffer(device);
  BatchPlan plan;
  plan.enters = needs.fragment_bytes && needs.bytes + needs.fragment_bytes <= budget && needs.fragment_bytes <= largest;
  const uint64_t bytes = needs.bytes + (plan.enters ? needs.fragment_bytes : 0);
  plan.in_flight = bytes > budget ? 1 : 2;
  const uint64_t per_buffer = std::max(needs.largest_buffer_bytes, plan.enters ? needs.fragment_bytes : 0);
  const uint64_t by_memory = std::max<uint64_t>(1, std::min(budget / bytes, largest / per_buffer));
  const uint64_t worthwhile = std::max<uint64_t>(kTrialDirections, kBatchWork / std::max(needs.polygon_count, needs.tile_count));
  const uint64_t chosen = options.batch_directions ? options.batch_directions : std::min(by_memory, worthwhile);
  plan.directions = static_cast<uint32_t>(std::min<uint64_t>(
      {chosen, limits.maxComputeWorkGroupCount[1], (1ull << 31) / std::max(needs.row_count, 3 * needs.polygon_count),
       std::max<uint64_t>(1, uint64_t(limits.maxComputeWorkGroupCount[0]) * kGroupSize / needs.polygon_count)}));
  if (plan.directions == 0) throw Error(ErrorCode::limit, fmt::format("one direction has {} tile rows and {} polygons, more than can be addressed; "
                                                                      "try a smaller --resolution or scene", needs.row_count, needs.polygon_count));
  return plan;
}

bool planSmaller(const BatchPlan& plan, LatticeOptions& options) {
  if (plan.directions > 1) options.batch_directions = plan.directions / 2;
  else if (plan.in_flight > 1 || plan.enters) options.memory_budget_bytes = 1;
  else return false;
  return true;
}

uint64_t largestBuffer(const Device& device) {
  return std::min<uint64_t>(device.maxAllocationBytes(), device.properties().limits.maxTexelBufferElements * uint64_t(8));
}

}  // namespace viewpeel
