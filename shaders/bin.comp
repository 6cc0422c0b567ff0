#version 460
// One invocation takes one polygon in one direction, and some rows of tiles, and finds the tiles of lattice points that it can cover: first to count them, then, when
// lists have been allocated, to enter itself.
//   In: projected, edges     counting: Out tile_counts     scattering: In tile_starts, Out lists; tile_counts is counted down to 0
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { BinArgs args; };

// False where the whole tile lies outside of one of the polygon's edges, of the first ones where it has many.
bool reachesTile(uint edge_at, uint corner_count, ivec2 origin) {
  for (uint k = 0u; k < min(corner_count, kMostEdgesTested); ++k) {
    Edge edge = Edges(args.edges).at[edge_at + k];
    int64_t most = int64_t(edge.a) * int64_t(origin.x) + int64_t(edge.b) * int64_t(origin.y) + edge.c +
                   int64_t(kTileSize - 1) * (int64_t(max(edge.a, 0)) + int64_t(max(edge.b, 0)));
    if (most < int64_t(0)) return false;
  }
  return true;
}

void main() {
  uint polygon_index = gl_GlobalInvocationID.x;
  uint direction_index = gl_WorkGroupID.y;
  if (polygon_index >= args.polygon_count) return;
  ProjectedPolygon polygon = Projected(args.projected).at[direction_index * args.polygon_count + polygon_index];
  if (polygon.box_min.x > polygon.box_max.x) return;
  PolygonData data = Polygons(args.polygons).at[polygon_index];
  uint edge_at = direction_index * args.corner_count + data.first_corner;
  int half_window = int(args.tiles_per_side) * kTileSize / 2;
  ivec2 first = (polygon.box_min + half_window) / kTileSize, last = (polygon.box_max + half_window) / kTileSize;
  int first_row = int(gl_WorkGroupID.z * args.rows_per_invocation);
  first.y = max(first.y, first_row);
  last.y = min(last.y, first_row + int(args.rows_per_invocation) - 1);
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      if (!reachesTile(edge_at, data.corner_count, ivec2(x, y) * kTileSize - half_window)) continue;
      uint tile = (direction_index * args.tiles_per_side + uint(y)) * args.tiles_per_side + uint(x);
      if (args.scatter == 0u) {
        atomicAdd(Words(args.tile_counts).at[tile], 1u);
      } else {
        uint at = Words(args.tile_starts).at[tile] + atomicAdd(Words(args.tile_counts).at[tile], ~0u) - 1u;
        if (at < args.list_capacity) Words(args.lists).at[at] = polygon_index;
      }
    }
}
