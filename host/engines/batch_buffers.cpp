#include "engines/batch_buffers.h"

#include <algorithm>

#include <fmt/format.h>

#include "engines/shared.h"
#include <viewpeel/error.h>

namespace viewpeel {

using namespace device_data;

namespace {

constexpr VkFormat kOneWord = VK_FORMAT_R32_UINT, kTwoWords = VK_FORMAT_R32G32_UINT,
                   kFourWords = VK_FORMAT_R32G32B32A32_UINT;

}  // namespace

std::vector<BufferSize> listBuffers(const BatchShape& shape) {
  using B = BatchBuffers;
  using enum BufferUse;
  const uint64_t directions = shape.directions, polygons = directions * shape.polygon_count,
                 tiles = directions * shape.tilesPerDirection();
  const uint64_t parts = tiles * shape.parts_per_tile, reached = parts * shape.samples_per_part,
                 entries = shape.list_capacity;
  const uint64_t points = shape.enters ? directions * shape.pointsPerDirection() : 0;
  const uint64_t covers = shape.meets ? entries : 0;
  // A tile has one meeting for every subgroup_size of its polygons; the last meeting may have fewer.
  const uint64_t meetings = shape.meets ? tiles + entries / shape.subgroup_size : 0;
  return {
      {&B::directions, directions * sizeof(DirectionData), control, kFourWords, MemoryUse::upload},
      {&B::listed, polygons * sizeof(uint32_t), control},
      {&B::snapped_corners, polygons * sizeof(SnappedCorners), projections, kFourWords},
      {&B::projected, polygons * sizeof(ProjectedPolygon), projections, kFourWords},
      {&B::fragments, points * shape.fragment_capacity * sizeof(uint64_t), fragments, kTwoWords},
      {&B::fragment_counts, points * sizeof(uint32_t), fragments, kOneWord},
      {&B::tile_roles, shape.has_roles ? tiles * sizeof(uint32_t) : 0, control},
      {&B::emitter_spans, shape.has_roles ? directions * shape.tiles_high * 2 * sizeof(uint32_t) : 0, control},
      {&B::tile_counts, tiles * sizeof(uint32_t), lists},
      {&B::tile_starts, tiles * sizeof(uint32_t), lists},
      {&B::active_tiles, parts * sizeof(ActiveTile), lists, kFourWords},
      {&B::entries, shape.sorts ? entries * sizeof(ListEntry) : 0, lists, kTwoWords},
      {&B::lists, entries * sizeof(uint32_t), lists, kOneWord},
      {&B::covers, covers * sizeof(Cover), lists, kFourWords},
      {&B::cover_polygons, covers * sizeof(uint32_t), lists, kOneWord},
      {&B::meetings, meetings * sizeof(Meeting), lists},
      {&B::unfinished, parts * sizeof(UnfinishedTile), unfinished},
      {&B::reached, reached * sizeof(uint64_t), unfinished},
      {&B::unfinished_next, parts * sizeof(UnfinishedTile), unfinished},
      {&B::reached_next, reached * sizeof(uint64_t), unfinished},
      {&B::status, sizeof(BatchStatus), control},
      {&B::status_read, sizeof(BatchStatus), control, VK_FORMAT_UNDEFINED, MemoryUse::readback},
  };
}

void fitBuffers(const Device& device, const BatchShape& shape, BatchBuffers& buffers) {
  if (shape.list_capacity > mostListed(device)) throw listsTooLong(device);
  const std::vector<BufferSize> sizes = listBuffers(shape);
  const auto isTooSmall = [&](const BufferSize& size) { return (buffers.*size.buffer).sizeBytes() < size.size_bytes; };
  for (const BufferSize& size : sizes)
    if (isTooSmall(size)) buffers.*size.buffer = Buffer();  // frees all of them before the first new one is made
  for (const BufferSize& size : sizes)
    if (isTooSmall(size)) buffers.*size.buffer = Buffer(device, size.size_bytes, size.memory, size.texels);
}

uint64_t mostListed(const Device& device) {
  return std::min<uint64_t>(device.properties().limits.maxTexelBufferElements, 0x7FFFFFFF);
}

Error listsTooLong(const Device& device) {
  return Error(
      ErrorCode::memory,
      fmt::format("polygons reach more than {} tiles, which is as many as {} can address; try a smaller --resolution",
                  mostListed(device), device.description().name));
}

uint64_t sizeBytes(const BatchShape& shape) {
  uint64_t bytes = 0;
  for (const BufferSize& size : listBuffers(shape)) bytes += size.size_bytes;
  return bytes;
}

uint64_t largestBytes(const BatchShape& shape) {
  uint64_t largest = 0;
  for (const BufferSize& size : listBuffers(shape))
    largest = std::max(largest, size.size_bytes * (size.texels == kOneWord ? 2 : 1));
  return largest;
}

uint64_t sizeBytes(const BatchBuffers& buffers, BufferUse use) {
  uint64_t bytes = 0;
  for (const BufferSize& size : listBuffers({.subgroup_size = 1}))
    if (size.use == use) bytes += (buffers.*size.buffer).sizeBytes();
  return bytes;
}

uint64_t sizeBytes(const BatchBuffers& buffers) {
  uint64_t bytes = 0;
  for (const BufferSize& size : listBuffers({.subgroup_size = 1})) bytes += (buffers.*size.buffer).sizeBytes();
  return bytes;
}

}  // namespace viewpeel
