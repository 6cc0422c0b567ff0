// listBuffers lists the buffers of one batch of directions, with their contents, size and use. Plans, allocation,
// growth and the summary of memory all read this list.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/error.h>
#include "vulkan/buffer.h"

namespace viewpeel {

// A BatchShape has all numbers from which the sizes of a batch's buffers follow.
struct BatchShape {
  uint32_t directions = 1;  // most directions of a batch
  uint32_t polygon_count = 0;
  uint32_t tiles_wide = 0, tiles_high = 0;  // grid of tiles of one direction
  uint32_t points_per_tile = 0;             // lattice points
  uint32_t parts_per_tile = 1;              // most workgroups of peel that share a tile
  uint32_t subgroup_size = 0;               // invocations
  uint32_t samples_per_part = 0;            // samples whose layers a workgroup of peel keeps at once
  bool has_roles = false;                   // only some polygons emit or receive
  bool sorts = false;                       // the pass sort orders lists by depth
  bool enters = false;                      // polygons over few lattice points become fragments
  bool meets = false;                       // the passes cover and meet count blocked pairs
  uint64_t list_capacity = 0;               // entries of all tiles' lists together
  uint32_t fragment_capacity = 0;           // most fragments of a lattice point

  // Returns whether the pass allocate visits only the tiles between the first and the last emitter of each row of
  // tiles. Around long thin emitters most tiles of a wide window are empty.
  bool allocatesRows() const { return has_roles && tiles_wide >= 64; }
  uint32_t tilesPerDirection() const { return tiles_wide * tiles_high; }
  uint32_t pointsPerDirection() const { return tilesPerDirection() * points_per_tile; }
};

struct BatchBuffers {
  Buffer directions, listed, snapped_corners, projected;
  Buffer fragments, fragment_counts;
  Buffer tile_roles, emitter_spans, tile_counts, tile_starts, active_tiles, entries, lists;
  Buffer covers, cover_polygons, meetings;
  Buffer unfinished, reached;            // unfinished tiles that a dispatch of peel resumes
  Buffer unfinished_next, reached_next;  // tiles that this dispatch leaves unfinished
  Buffer status, status_read;
};

// The summary of memory adds up buffers by their use.
enum class BufferUse { control, projections, lists, fragments, unfinished };

struct BufferSize {
  Buffer BatchBuffers::*buffer;
  uint64_t size_bytes;  // 0: a batch of this shape has no such buffer
  BufferUse use;
  VkFormat texels = VK_FORMAT_UNDEFINED;  // format of the buffer's texels, where passes read it as texels
  MemoryUse memory = MemoryUse::device;
};

// Returns the buffers that a batch of this shape has, one entry for each member of BatchBuffers.
std::vector<BufferSize> listBuffers(const BatchShape& shape);

// Makes every buffer that is missing or too small for the shape. The contents of these buffers are lost; the others
// stay.
//   Throws: Error memory where the device has no room, or where lists are longer than mostListed.
void fitBuffers(const Device& device, const BatchShape& shape, BatchBuffers& buffers);

// Returns the most entries that a batch's lists can have together. Shaders read entries as texels, of which a device
// allows only so many, and hold their indices in 31 bits.
uint64_t mostListed(const Device& device);

// Returns the error for lists that are longer than mostListed. Its code is memory, for smaller batches help here, too.
Error listsTooLong(const Device& device);

// sizeBytes returns the bytes of all buffers that a batch of this shape has, largestBytes the bytes of the largest one.
// The latter counts buffers of 4-byte texels twice, because largestBuffer allows as many texels as if each had 8 bytes.
uint64_t sizeBytes(const BatchShape& shape);
uint64_t largestBytes(const BatchShape& shape);

// Return the bytes that a batch's buffers have now: of all buffers, and of the buffers for one use.
uint64_t sizeBytes(const BatchBuffers& buffers);
uint64_t sizeBytes(const BatchBuffers& buffers, BufferUse use);

}  // namespace viewpeel
