#version 460
// One invocation gives one tile with any polygon or fragment room for its list and a place among the active tiles. With
// scanlines the tile gets one place for each group of rows that peel takes at once. With kTakesRows one workgroup takes
// a whole row of tiles, from the first to the last tile that holds an emitting polygon.
//   In: tile_counts, emitter_spans, fragment_counts   Out: tile_starts, active_tiles, status
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kFragments = false;
layout(constant_id = 1) const uint kTileWidth = 8u;
layout(constant_id = 2) const uint kTileRows = 8u;
layout(constant_id = 3) const bool kScanlines = false;
layout(constant_id = 4) const bool kTakesRows = false;
layout(push_constant, scalar) uniform Args { BinArgs pushed; };
BinArgs args;

void allocate(uint tile) {
  uint count = Words(args.tile_counts).at[tile];
  Status status = Status(args.status);
  const uint points = kTileWidth * kTileRows;
  uint most_fragments = 0u;
  if (kFragments) {
    for (uint k = 0u; k < points; ++k)
      most_fragments = max(most_fragments, Words(args.fragment_counts).at[tile * points + k]);
    if (most_fragments > args.fragment_capacity) {
      atomicMax(status.at.most_fragments, most_fragments);
      atomicOr(status.at.active_tiles, kListsOverflowed);
    }
  }
  if (count == 0u && most_fragments == 0u) return;
  uint start = count == 0u ? 0u : atomicAdd(status.at.list_length, count);
  Words(args.tile_starts).at[tile] = start;
  if (start + count > args.list_capacity || start + count < start) {
    atomicOr(status.at.active_tiles, start + count < start ? kListsOverflowed | kListsUncountable : kListsOverflowed);
    return;
  }
  const uint rows = kScanlines ? rowsAtOnce(count, kTileRows) : kTileRows, parts = kTileRows / rows;
  uint place = atomicAdd(status.at.active_tiles, parts) & ~(kListsOverflowed | kListsUncountable),
       groups = place + parts;
  atomicMax(status.at.peel_groups.x, min(groups, kGroupsPerRow));
  atomicMax(status.at.peel_groups.y, (groups - 1u) / kGroupsPerRow + 1u);
  uint tiles_per_direction = args.tiles_wide * args.tiles_high;
  uint direction = tile / tiles_per_direction, in_direction = tile - direction * tiles_per_direction;
  uint y = in_direction / args.tiles_wide, x = in_direction - y * args.tiles_wide;
  ActiveTile found;
  found.list_start = start;
  found.list_length = count;
  found.direction = direction;
  found.weight = Directions(args.directions).at[direction].weight;
  found.block = Directions(args.directions).at[direction].block;
  found.column = int(x * kTileWidth) - int(args.tiles_wide * kTileWidth / 2u);
  found.row = int(y * kTileRows) - int(args.tiles_high * kTileRows / 2u);
  found.most_fragments = most_fragments;
  found.first_point = tile * points;
  for (uint part = 0u; part < parts; ++part) {
    ActiveTiles(args.active_tiles).at[place + part] = found;
    found.row += int(rows);
  }
}

void main() {
  args = pushed;
  if (!kTakesRows) {
    if (gl_GlobalInvocationID.x < args.tile_count) allocate(gl_GlobalInvocationID.x);
    return;
  }
  uint row = gl_WorkGroupID.x, end = Words(args.emitter_spans).at[2u * row + 1u];
  uint first = args.tiles_wide - Words(args.emitter_spans).at[2u * row];
  for (uint x = first + gl_LocalInvocationID.x; x < end; x += gl_WorkGroupSize.x) allocate(row * args.tiles_wide + x);
}
