#include "engines/batch_plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "engines/lattice.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

constexpr uint64_t kBatchWork = 1u << 17;  // with this many polygons, or tiles, the cost of a submission matters little

// Returns the shape of a batch of one direction, without fragments. Its tiles cover the window's ball wherever the
// lattice's offset puts it, and form a grid that is symmetric about the lattice's origin.
BatchShape shapeOf(const LatticeOptions& options, const Tuning& tuning, const BatchNeeds& needs) {
  const auto reach = static_cast<uint64_t>(windowReach(options.resolution, options.window));
  const bool is_lattice = options.sampling == Sampling::lattice;
  BatchShape shape{
      .polygon_count = needs.polygon_count,
      .tiles_wide = 2 * divideUp(reach, tuning.tile_width),
      .tiles_high = 2 * divideUp(reach, tuning.tile_rows),
      .points_per_tile = tuning.tile_width * tuning.tile_rows,
      .parts_per_tile = is_lattice ? 1 : tuning.tile_rows,
      .subgroup_size = tuning.subgroup_size,
      .samples_per_part = tuning.subgroup_size * tuning.steps,
      .has_roles = !needs.all_count,
      .sorts = tuning.sorts,
      .meets = options.count_blocked && is_lattice,
      .fragment_capacity = needs.fragment_capacity,
  };
  shape.list_capacity = 4 * uint64_t(shape.polygon_count) + shape.tilesPerDirection();
  return shape;
}

}  // namespace

BatchPlan planBatches(const Device& device, const LatticeOptions& options, const Tuning& tuning,
                      const BatchNeeds& needs) {
  BatchPlan plan{shapeOf(options, tuning, needs)};
  BatchShape& shape = plan.shape;
  const uint64_t tiles = shape.tilesPerDirection(), parts = tiles * shape.parts_per_tile,
                 polygons = shape.polygon_count;
  const uint64_t bytes_without = sizeBytes(shape), largest_without = largestBytes(shape);
  const VkPhysicalDeviceLimits& limits = device.properties().limits;
  const uint64_t available = options.available_bytes ? options.available_bytes : device.memoryBytes();
  if (needs.fixed_bytes + bytes_without > available)
    throw Error(ErrorCode::limit,
                fmt::format("{} polygons at resolution {} need {:.0f} MiB, {} has {:.0f} MiB; try a smaller "
                            "--resolution or scene, or --by surface",
                            polygons, options.resolution, double(needs.fixed_bytes + bytes_without) / 1048576.0,
                            device.description().name, double(available) / 1048576.0));
  if (divideUp(polygons, kGroupSize) > limits.maxComputeWorkGroupCount[0])
    throw Error(ErrorCode::limit, fmt::format("{} polygons are more than {} can project at once; try a smaller scene",
                                              polygons, device.description().name));
  const uint64_t wanted = options.memory_budget_bytes ? options.memory_budget_bytes : kMemoryBudget;
  const uint64_t budget = std::min<uint64_t>(wanted, available - needs.fixed_bytes) / 2,
                 largest = largestBuffer(device);

  shape.enters =
      *options.few_points && options.sampling == Sampling::lattice && needs.all_count && !options.count_blocked;
  shape.enters = shape.enters && sizeBytes(shape) <= budget && largestBytes(shape) <= largest;
  const uint64_t bytes = shape.enters ? sizeBytes(shape) : bytes_without,
                 per_buffer = shape.enters ? largestBytes(shape) : largest_without;
  plan.in_flight = bytes > budget ? 1 : 2;
  const uint64_t by_memory = std::max<uint64_t>(1, std::min(budget / bytes, largest / per_buffer));
  const uint64_t worthwhile = std::max<uint64_t>(kTrialDirections, kBatchWork / std::max(polygons, tiles));
  const uint64_t chosen = options.batch_directions ? options.batch_directions : std::min(by_memory, worthwhile);
  shape.directions = static_cast<uint32_t>(std::min<uint64_t>(
      {chosen, limits.maxComputeWorkGroupCount[1], (1ull << 31) / std::max(parts, 3 * polygons),
       std::max<uint64_t>(1, uint64_t(limits.maxComputeWorkGroupCount[0]) * kGroupSize / polygons)}));
  if (shape.directions == 0)
    throw Error(ErrorCode::limit,
                fmt::format("one direction has {} tile rows and {} polygons, more than can be addressed; "
                            "try a smaller --resolution or scene",
                            parts, polygons));
  shape.list_capacity = options.list_capacity ? options.list_capacity : shape.directions * shape.list_capacity;
  return plan;
}

bool planSmaller(const BatchPlan& plan, LatticeOptions& options) {
  if (plan.shape.directions > 1) options.batch_directions = plan.shape.directions / 2;
  else if (plan.in_flight > 1 || plan.shape.enters) options.memory_budget_bytes = 1;
  else return false;
  return true;
}

uint64_t largestBuffer(const Device& device) {
  return std::min<uint64_t>(device.maxAllocationBytes(),
                            device.properties().limits.maxTexelBufferElements * uint64_t(8));
}

}  // namespace viewpeel
