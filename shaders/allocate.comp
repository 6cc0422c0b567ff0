#version 460
// One invocation gives one tile its list and, when it has any polygon, its place among the active tiles.
//   In: tile_counts   Out: tile_starts, active_tiles, status
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { BinArgs args; };

void main() {
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= args.tile_count) return;
  uint count = Words(args.tile_counts).at[tile];
  if (count == 0u) return;
  Status status = Status(args.status);
  uint start = atomicAdd(status.at.list_length, count);
  Words(args.tile_starts).at[tile] = start;
  if (start + count > args.list_capacity || start + count < start) {
    atomicOr(status.at.active_tiles, start + count < start ? kListsOverflowed | kListsUncountable : kListsOverflowed);
    return;
  }
  uint place = atomicAdd(status.at.active_tiles, 1u) & ~(kListsOverflowed | kListsUncountable);
  atomicMax(status.at.peel_groups.x, min(place + 1u, kGroupsPerRow));
  atomicMax(status.at.peel_groups.y, place / kGroupsPerRow + 1u);
  uint tiles_per_direction = args.tiles_wide * args.tiles_high;
  uint direction = tile / tiles_per_direction, in_direction = tile - direction * tiles_per_direction;
  uint y = in_direction / args.tiles_wide, x = in_direction - y * args.tiles_wide;
  ActiveTile found;
  found.list_start = start;
  found.list_length = count;
  found.direction = direction;
  found.weight = Directions(args.directions).at[direction].weight;
  found.block = Directions(args.directions).at[direction].block;
  found.column = int(x * args.tile_width) - int(args.tiles_wide * args.tile_width / 2u);
  found.row = int(y * args.tile_rows) - int(args.tiles_high * args.tile_rows / 2u);
  ActiveTiles(args.active_tiles).at[place] = found;
}
