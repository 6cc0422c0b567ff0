// The buffers of one batch of directions stand in one list, with contents, size and use. Plans, allocation, growth and
// the summary of memory all read this list.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/error.h>
#include "vulkan/buffer.h"

namespace viewpeel {

// The sizes of a batch's buffers follow from its shape.
struct BatchShape {
  uint32_t directions = 1;  // at most
  uint32_t polygon_count = 0;
  uint32_t tiles_wide = 0, tiles_high = 0;  // of a direction
  uint32_t points_per_tile = 0;             // lattice points
  uint32_t parts_per_tile = 1;              // workgroups of peel
  uint32_t subgroup_size = 0;
  uint32_t samples_per_part = 0;   // whose layers a workgroup of peel keeps
  bool has_roles = false;          // only some polygons count
  bool sorts = false;              // lists by depth
  bool enters = false;             // polygons over few lattice points become fragments
  bool meets = false;              // blocked pairs are counted by passes of their own
  uint64_t list_capacity = 0;      // entries of all tiles' lists together
  uint32_t fragment_capacity = 0;  // of a lattice point

  // Returns whether allocate takes rows of tiles, each in the span of its emitters, and not every tile: wide windows
  // are mostly empty around long thin emitters.
  bool allocatesRows() const { return has_roles && tiles_wide >= 64; }
  uint32_t tilesPerDirection() const { return tiles_wide * tiles_high; }
  uint32_t pointsPerDirection() const { return tilesPerDirection() * points_per_tile; }
};

struct BatchBuffers {
  Buffer directions, listed, snapped_corners, projected;
  Buffer fragments, fragment_counts;
  Buffer tile_roles, emitter_spans, tile_counts, tile_starts, active_tiles, entries, lists;
  Buffer covers, cover_polygons, meetings;
  Buffer unfinished, reached;            // the rest of tiles that a dispatch of peel takes up
  Buffer unfinished_next, reached_next;  // and leaves
  Buffer status, status_read;
};

// The summary of memory adds up buffers by their use.
enum class BufferUse { control, projections, lists, fragments, unfinished };

struct BufferSize {
  Buffer BatchBuffers::*buffer;
  uint64_t size_bytes;  // 0: a batch of this shape has no such buffer
  BufferUse use;
  VkFormat texels = VK_FORMAT_UNDEFINED;  // where passes read it as texels
  MemoryUse memory = MemoryUse::device;
};

// A batch has these buffers, in the order of shaders/shared.h's passes.
//   Out: one row a member of BatchBuffers
std::vector<BufferSize> listBuffers(const BatchShape& shape);

// Makes every buffer that is missing or too small; the contents of these buffers are lost.
//   Throws: Error memory where the device has no room, or lists are longer than it can address.
void fitBuffers(const Device& device, const BatchShape& shape, BatchBuffers& buffers);

// Returns the number of list entries that a batch can have: texels, whose numbers shaders hold in 31 bits.
uint64_t mostListed(const Device& device);

// Returns the error for polygons that reach too many tiles: smaller batches have shorter lists, as where memory is
// short.
Error listsTooLong(const Device& device);

// Return the bytes of all buffers of a batch together, and of the largest, as if no texel had fewer than 8.
uint64_t sizeBytes(const BatchShape& shape);
uint64_t largestBytes(const BatchShape& shape);

// Returns the bytes of a batch's buffers, of all or of the buffers for one use.
uint64_t sizeBytes(const BatchBuffers& buffers);
uint64_t sizeBytes(const BatchBuffers& buffers, BufferUse use);

}  // namespace viewpeel
