#include "engines/tuning.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "engines/shared.h"
#include <viewpeel/error.h>

namespace viewpeel {

using namespace device_data;

namespace {

constexpr uint32_t kFewPoints = 64;  // lattice points in a polygon's box, which holds up to three times its own points
constexpr double kFewAcross = 5;     // spacings along a square of a polygon's mean projected area that has such a box

constexpr uint32_t kLongList = 48;    // tiles are made smaller where they have this many polygons on average
constexpr double kManyRounds = 1.5;   // more layers are kept where tiles take more rounds than this on average
constexpr uint32_t kSortedList = 16;  // lists are then sorted where tiles have this many polygons on average
constexpr uint32_t kDeepList = 16;    // with scanlines, more layers are kept where tiles have this many on average

}  // namespace

Tuning tune(const Device& device, const LatticeOptions& options) {
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  if (subgroup.subgroupSize < 8 || subgroup.subgroupSize > 64 ||
      !(subgroup.supportedOperations & VK_SUBGROUP_FEATURE_SHUFFLE_BIT))
    throw Error(ErrorCode::device,
                fmt::format("{}: subgroups of {} without shuffle, or not of 8 to 64; use --engine graphics",
                            device.description().name, subgroup.subgroupSize));
  const bool on_cpu = device.properties().deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  const auto choose = [](uint32_t requested, uint32_t otherwise) { return requested ? requested : otherwise; };
  const uint32_t subgroup_size = subgroup.subgroupSize, layers_kept = choose(options.layers_kept, 4),
                 most_blocks = choose(options.most_blocks, on_cpu ? 1000 : 1u << 30);
  // Every scanline searches all polygons of its tile for spans. Tiles of few scanlines hold fewer polygons, and are
  // faster.
  const uint32_t default_rows = options.sampling == Sampling::lattice ? kMostTileRows
                                : options.resolution < 128            ? 2
                                                                      : 4;
  const uint32_t tile_rows = std::min(std::bit_ceil(choose(options.tile_rows, default_rows)), kMostTileRows);
  if (options.sampling == Sampling::scanline)
    return {subgroup_size, kScanlineCell, tile_rows, 1, layers_kept, most_blocks, false};
  // With lattice points the tile's width divides the subgroup's size, and a subgroup takes some rows at each step.
  const uint32_t tile_width = std::min(std::bit_ceil(choose(options.tile_width, 8)), kMostTileWidth);
  return {subgroup_size, tile_width,  tile_rows,   std::max(1u, tile_width * tile_rows / subgroup_size),
          layers_kept,   most_blocks, options.sort};
}

void adaptOptions(const BatchStatus& found, LatticeOptions& options) {
  const uint32_t list_length = found.list_length / found.active_tiles;
  if (options.sampling == Sampling::scanline) {
    if (!options.layers_kept && list_length >= kDeepList) options.layers_kept = 6;
    return;
  }
  if (!options.tile_rows && list_length >= kLongList) options.tile_rows = 4;
  if (!options.layers_kept && found.rounds > kManyRounds * found.active_tiles) {
    options.sort = list_length >= kSortedList;
    options.layers_kept = 8;
  }
}

// It is quicker to add to dense counters than to a hash table, but takes longer to read them after every replicate. So
// dense counters may be larger on finer lattices, where a direction adds more.
uint64_t counterBudget(const LatticeOptions& options) {
  const uint64_t chosen = options.resolution < 128 ? 256ull << 20 : 512ull << 20;
  return options.counter_budget_bytes ? options.counter_budget_bytes : options.count_blocked ? 2 * chosen : chosen;
}

// Polygons that become fragments leave the tiles' lists, whose polygons are tested against every point of the tile.
// Unless they are most of the lists' entries, room for fragments costs more than this saves. The number of a polygon's
// entries is estimated for tiles of 8 x 8 points and its mean projection, which is half its area.
uint32_t chooseFewPoints(const Scene& scene, int resolution) {
  double entries = 0, spared = 0;
  for (const Polygon& polygon : scene.polygons) {
    const double across = std::sqrt(polygon.area / 2) * resolution / 2, its = (across / 8 + 1) * (across / 8 + 1);
    entries += its;
    spared += across <= kFewAcross ? its : 0;
  }
  return spared > entries / 2 ? kFewPoints : 0;
}

}  // namespace viewpeel
