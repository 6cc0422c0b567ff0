// The passes, in order, for a batch of directions:
//   project    every polygon along every direction: edges, box and depth over the lattice
//   bin        count the polygons that reach each tile
//   allocate   give every tile its list, list the active tiles
//   bin        fill the lists
//   peel       every active tile: layers in order, facing rules, counters
// Before peel the host reads how long the lists had to be. Where they were too small they grow and the batch is binned again.
#include "engines/compute_engine.h"

#include <algorithm>

#include <fmt/format.h>

#include "engines/pair_counters.h"
#include "engines/shared.h"
#include "error.h"
#include "shaders/allocate.comp.h"
#include "shaders/bin.comp.h"
#include "shaders/peel.comp.h"
#include "shaders/project.comp.h"
#include "vulkan/commands.h"

namespace viewpeel {
namespace {

using namespace device_data;

constexpr uint32_t kGroupSize = 64;             // local_size_x of all passes but peel
constexpr uint64_t kBatchBytes = 64u << 20;     // of projected polygons
constexpr uint64_t kBatchPoints = 1u << 20;     // lattice points
constexpr uint64_t kMostCounts = 0xFFFFFFFFull;  // in a device counter

uint32_t divideUp(uint64_t value, uint64_t by) { return static_cast<uint32_t>((value + by - 1) / by); }

class ComputeEngine : public Engine {
 public:
  ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options);
  PairCounts count(std::span<const Direction> directions) override;
  double unitArea() const override { return 4.0 / (double(options_.resolution) * options_.resolution); }

 private:
  void planBatch();
  void growLists(uint64_t needed);
  // False where the lists were too small: nothing has been counted, and they have grown.
  bool countBatch(std::span<const Direction> directions);

  const Device& device_;
  LatticeOptions options_;
  bool two_sided_;
  int fraction_bits_;
  SceneBuffers scene_;
  PairCounters counters_;
  uint32_t subgroup_size_, tiles_per_side_, batch_size_;

  Kernel project_, bin_, allocate_, peel_;
  Commands commands_;
  Buffer directions_, edges_, projected_, tile_counts_, tile_starts_, active_tiles_, lists_, status_, status_read_;
};

// A polygon of a tile's list adds at most one count at each of the tile's points, and every line ends in one gap more.
uint64_t mostCounts(uint64_t list_entries, uint64_t tiles) { return uint64_t(kTileSize) * kTileSize * (list_entries + tiles); }

uint32_t subgroupSize(const Device& device) {
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  constexpr VkSubgroupFeatureFlags kNeeded = VK_SUBGROUP_FEATURE_VOTE_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
  if (subgroup.subgroupSize < 8 || subgroup.subgroupSize > 64 || (subgroup.supportedOperations & kNeeded) != kNeeded)
    throw Error(ErrorCode::device, fmt::format("{}: subgroups of {} without vote and shuffle, or not of 8 to 64; use --engine graphics",
                                               device.description().name, subgroup.subgroupSize));
  return subgroup.subgroupSize;
}

ComputeEngine::ComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options)
    : device_(device),
      options_(options),
      two_sided_(ids.two_sided),
      fraction_bits_(chooseFractionBits(options.resolution)),
      scene_(device, scene, ids),
      counters_(device, ids.count(), options.counter_budget_bytes),
      subgroup_size_(subgroupSize(device)),
      project_(device, project_comp, sizeof(ProjectArgs)),
      bin_(device, bin_comp, sizeof(BinArgs)),
      allocate_(device, allocate_comp, sizeof(BinArgs)),
      peel_(device, peel_comp, sizeof(PeelTilesArgs), subgroup_size_),
      commands_(device) {
  tiles_per_side_ = 2 * divideUp(static_cast<uint64_t>(options.resolution / 2 + 2), kTileSize);
  planBatch();
  directions_ = Buffer(device, batch_size_ * sizeof(DirectionData), MemoryUse::upload);
  edges_ = Buffer(device, uint64_t(batch_size_) * scene_.corner_count * sizeof(Edge), MemoryUse::device);
  projected_ = Buffer(device, uint64_t(batch_size_) * scene_.polygon_count * sizeof(ProjectedPolygon), MemoryUse::device);
  const uint64_t tiles = uint64_t(batch_size_) * tiles_per_side_ * tiles_per_side_;
  tile_counts_ = Buffer(device, tiles * sizeof(uint32_t), MemoryUse::device);
  tile_starts_ = Buffer(device, tiles * sizeof(uint32_t), MemoryUse::device);
  active_tiles_ = Buffer(device, tiles * 2 * sizeof(uint32_t), MemoryUse::device);
  status_ = Buffer(device, sizeof(BinStatus), MemoryUse::device);
  status_read_ = Buffer(device, sizeof(BinStatus), MemoryUse::readback);
  lists_ = Buffer(device, (options.list_capacity ? options.list_capacity : 4 * uint64_t(batch_size_) * scene_.polygon_count) * sizeof(uint32_t),
                  MemoryUse::device);
}

void ComputeEngine::planBatch() {
  const uint64_t bytes = uint64_t(scene_.polygon_count) * sizeof(ProjectedPolygon) + uint64_t(scene_.corner_count) * sizeof(Edge);
  const uint64_t points = uint64_t(tiles_per_side_) * tiles_per_side_ * kTileSize * kTileSize;
  const uint64_t chosen = std::max<uint64_t>(1, std::min(kBatchBytes / bytes, kBatchPoints / points));
  batch_size_ = static_cast<uint32_t>(std::min<uint64_t>({options_.batch_directions ? options_.batch_directions : chosen,
                                                          device_.properties().limits.maxComputeWorkGroupCount[1], (1u << 28) / points + 1}));
}

// Lists of `needed` entries, or, where counters could overflow within one batch of that size, half the batch.
void ComputeEngine::growLists(uint64_t needed) {
  const uint64_t tiles = uint64_t(batch_size_) * tiles_per_side_ * tiles_per_side_;
  if (mostCounts(needed, tiles) > kMostCounts) {
    if (batch_size_ == 1)
      throw Error(ErrorCode::limit, fmt::format("polygons of one direction reach {} tiles, too many for 32-bit counters; try a smaller --resolution",
                                                needed));
    batch_size_ /= 2;
    return;
  }
  lists_ = Buffer(device_, needed * sizeof(uint32_t), MemoryUse::device);
}

PairCounts ComputeEngine::count(std::span<const Direction> directions) {
  counters_.start(commands_);
  for (size_t done = 0; done < directions.size();) {
    const size_t batch = std::min<size_t>(batch_size_, directions.size() - done);
    if (countBatch(directions.subspan(done, batch))) done += batch;
  }
  return counters_.finish(commands_);
}

bool ComputeEngine::countBatch(std::span<const Direction> directions) {
  const auto direction_count = static_cast<uint32_t>(directions.size());
  const uint32_t tile_count = direction_count * tiles_per_side_ * tiles_per_side_;
  const auto list_capacity = static_cast<uint32_t>(lists_.sizeBytes() / sizeof(uint32_t));
  std::span<DirectionData> data = directions_.mapped<DirectionData>();
  for (uint32_t k = 0; k < direction_count; ++k)
    data[k] = {directions[k].x_axis, directions[k].y_axis, directions[k].u, directions[k].offset};
  counters_.makeRoom(commands_, mostCounts(list_capacity, tile_count));

  commands_.begin();
  const BinStatus none{0, 0, 0};
  vkCmdUpdateBuffer(commands_.handle(), status_.handle(), 0, sizeof none, &none);
  commands_.fill(tile_counts_, 0, tile_count * sizeof(uint32_t));
  const ProjectArgs project{directions_.address(), scene_.polygons.address(), scene_.corners.address(), edges_.address(), projected_.address(),
                            scene_.polygon_count, scene_.corner_count, direction_count, options_.resolution, fraction_bits_,
                            static_cast<uint32_t>(options_.resolution) + 4};
  const uint32_t polygon_groups = divideUp(scene_.polygon_count, kGroupSize);
  commands_.dispatch(project_, project, polygon_groups, direction_count);
  commands_.barrier();
  BinArgs bin{scene_.polygons.address(), edges_.address(), projected_.address(), tile_counts_.address(), tile_starts_.address(), lists_.address(),
              active_tiles_.address(), status_.address(), scene_.polygon_count, scene_.corner_count, tiles_per_side_, tile_count, list_capacity, 0,
              std::max(1u, kMostTilesPerInvocation / tiles_per_side_)};
  const uint32_t row_groups = divideUp(tiles_per_side_, bin.rows_per_invocation);
  commands_.dispatch(bin_, bin, polygon_groups, direction_count, row_groups);
  commands_.barrier();
  commands_.dispatch(allocate_, bin, divideUp(tile_count, kGroupSize), 1);
  commands_.barrier();
  bin.scatter = 1;
  commands_.dispatch(bin_, bin, polygon_groups, direction_count, row_groups);
  commands_.copy(status_, status_read_, sizeof(BinStatus));
  commands_.submitAndWait();
  const BinStatus found = status_read_.mapped<BinStatus>()[0];
  if (found.list_length > list_capacity) {
    growLists(uint64_t(found.list_length) + found.list_length / 4);
    return false;
  }

  commands_.begin();
  const PeelTilesArgs peel{scene_.polygons.address(), edges_.address(), projected_.address(), tile_starts_.address(), lists_.address(),
                           active_tiles_.address(), status_.address(), counters_.address(), scene_.polygon_count, scene_.corner_count, tiles_per_side_,
                           found.active_tiles, counters_.idCount(), two_sided_ ? 1u : 0u};
  commands_.dispatch(peel_, peel, std::min(found.active_tiles, kGroupsPerRow), divideUp(found.active_tiles, kGroupsPerRow),
                     kTileSize * kTileSize / subgroup_size_);
  commands_.barrier();
  commands_.copy(status_, status_read_, sizeof(BinStatus));
  commands_.submitAndWait();
  if (status_read_.mapped<BinStatus>()[0].truncated)
    throw Error(ErrorCode::limit, fmt::format("{}: more polygons over one tile than its loops can count; try a larger --resolution, or --engine graphics",
                                              device_.description().name));
  return true;
}

}  // namespace

std::unique_ptr<Engine> makeComputeEngine(const Device& device, const Scene& scene, const Ids& ids, const LatticeOptions& options) {
  return std::make_unique<ComputeEngine>(device, scene, ids, options);
}

}  // namespace viewpeel
