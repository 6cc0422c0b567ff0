#version 460
// One invocation gives one tile its list and, when it has any polygon, its place among the active tiles.
//   In: tile_counts   Out: tile_starts, active_tiles (tile, length), status
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
  Words(args.tile_starts).at[tile] = atomicAdd(status.at.list_length, count);
  uint place = atomicAdd(status.at.active_tiles, 1u);
  Words(args.active_tiles).at[2u * place] = tile;
  Words(args.active_tiles).at[2u * place + 1u] = count;
}
