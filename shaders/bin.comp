#version 460
// One invocation takes one listed polygon in one direction and finds the tiles, in some rows of tiles, in which it can
// cover samples. What it does there depends on kMode: it notes the polygon's roles (kBinEmitters, kBinReceivers),
// counts the tile's polygons (kBinCount), or writes the polygon into the tile's list (kBinScatter). Where only some
// polygons emit, it visits no tiles beyond the first and the last tile with emitters in a row: around long thin
// emitters most of a fine window is empty.
//   In: listed, projected, corners
//   Out: tile_roles, emitter_spans (emitters and receivers); tile_counts (count); lists (scatter, which counts
//     tile_counts down to 0)
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kMode = kBinCount;
layout(constant_id = 1) const bool kNeedsRoles = false;  // leaves out tiles whose polygons lack a needed role
layout(constant_id = 2) const bool kSorts = false;       // writes ListEntry, for sort
layout(constant_id = 3) const uint kTileWidth = 8u;
layout(constant_id = 4) const uint kTileRows = 8u;
layout(constant_id = 5) const int kColumnBits = 0;
layout(constant_id = 6) const int kCutBits = 0;  // see makeEdge
layout(push_constant, scalar) uniform Args { BinArgs pushed; };
BinArgs args;

const int kWideBox = 16;  // boxes this many tiles wide are clipped by the edges, which takes a division an edge

// Cuts the columns of tiles span.x to span.y of a row down to columns with reach + per_column x >= 0, rounded outward.
// The quotient is below 2^13, and single precision is off by at most 2^-22 of it. This error is less than the half tile
// that is added.
//   In: reach, per_column: the largest value of an edge over tile x of the row is reach + per_column x
ivec2 clipSpan(ivec2 span, int64_t reach, int64_t per_column) {
  if (per_column == int64_t(0)) return reach < int64_t(0) ? ivec2(0, -1) : span;
  float crossing = clamp(float(reach) / -float(per_column), float(span.x) - 1.0, float(span.y) + 1.0);
  if (per_column > int64_t(0)) return ivec2(max(span.x, int(ceil(crossing - 0.5))), span.y);
  return ivec2(span.x, min(span.y, int(floor(crossing + 0.5))));
}

void main() {
  args = pushed;
  if (gl_GlobalInvocationID.x >= Status(args.status).at.listed) return;
  if (kMode == kBinScatter && (Status(args.status).at.active_tiles & kListsOverflowed) != 0u) return;
  uint listed = Words(args.listed).at[gl_GlobalInvocationID.x];
  uint direction_index = listed / args.polygon_count, polygon_index = listed - direction_index * args.polygon_count;
  uint projected_at = kProjectedTexels * listed;
  ivec4 box = ivec4(texelFetch(projected_texels, int(projected_at)));
  const bool finds_emitters = kMode == kBinEmitters, finds_roles = finds_emitters || kMode == kBinReceivers;
  uint roles = finds_roles ? fetchId(polygon_index) >> kRolesShift : 0u;
  if (finds_roles && (roles == 0u || finds_emitters != ((roles & kEmits) != 0u))) return;

  // `most` has the largest value of each edge over the grid's first tile. From a tile to the next one it changes by
  // per_column and per_row.
  ivec2 grid = -ivec2(args.tiles_wide * kTileWidth, args.tiles_high * kTileRows) / 2;
  int64_t most[4], per_column[4], per_row[4];
  SnappedCorners corners = fetchCorners(listed);
  for (uint k = 0u; k < 4u; ++k) {
    Edge edge = makeEdge(corners, k, kCutBits);
    int64_t a = int64_t(edge.a), b = int64_t(edge.b) << kColumnBits;
    int64_t columns = int64_t(kTileWidth) << kColumnBits, rows = int64_t(kTileRows);
    per_column[k] = a * columns;
    per_row[k] = b * rows;
    most[k] = a * (int64_t(grid.x) << kColumnBits) + b * int64_t(grid.y) + edge.c +
              max(a, int64_t(0)) * (columns - int64_t(1)) + max(b, int64_t(0)) * (rows - int64_t(1));
  }
  uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u)),
        depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
  int64_t depth_x = depthXOf(longFrom(depth_01.zw));
  ivec2 tile_size = ivec2(kTileWidth, kTileRows);
  ivec2 first = (box.xy - grid) / tile_size, last = (box.zw - grid) / tile_size;
  int first_row = int(gl_WorkGroupID.z * args.rows_per_invocation);
  first.y = max(first.y, first_row);
  last.y = min(last.y, first_row + int(args.rows_per_invocation) - 1);
  for (int y = first.y; y <= last.y; ++y) {
    uint row = direction_index * args.tiles_high + uint(y);
    ivec2 span = ivec2(first.x, last.x), reached = ivec2(args.tiles_wide, -1);
    if (kNeedsRoles && !finds_emitters) {
      span.x = max(span.x, int(args.tiles_wide - Words(args.emitter_spans).at[2u * row]));
      span.y = min(span.y, int(Words(args.emitter_spans).at[2u * row + 1u]) - 1);
    }
    for (uint k = 0u; k < 4u && span.y - span.x >= kWideBox; ++k)
      span = clipSpan(span, most[k] + per_row[k] * int64_t(y), per_column[k]);
    for (int x = span.x; x <= span.y; ++x) {
      int64_t least_of_most = int64_t(0);
      for (uint k = 0u; k < 4u; ++k)
        least_of_most = min(least_of_most, most[k] + per_column[k] * int64_t(x) + per_row[k] * int64_t(y));
      if (least_of_most < int64_t(0)) continue;
      uint tile = row * args.tiles_wide + uint(x);
      if (finds_roles) {
        reached = ivec2(min(reached.x, x), x);
        atomicOr(Words(args.tile_roles).at[tile], roles);
        continue;
      }
      if (kNeedsRoles && (Words(args.tile_roles).at[tile] & args.needed_roles) != args.needed_roles) continue;
      if (kMode == kBinCount) {
        atomicAdd(Words(args.tile_counts).at[tile], 1u);
      } else {
        uint at = Words(args.tile_starts).at[tile] + atomicAdd(Words(args.tile_counts).at[tile], ~0u) - 1u;
        if (!kSorts) {
          Words(args.lists).at[at] = polygon_index;
          continue;
        }
        ivec2 corner = grid + ivec2(x, y) * tile_size;
        int64_t depth = longFrom(depth_01.xy) + depth_x * int64_t(corner.x) + longFrom(depth_2.xy) * int64_t(corner.y);
        ListEntry entry;
        entry.polygon = polygon_index;
        entry.nearest_depth = nearestDepth(depth, depth_x, longFrom(depth_2.xy), depthShiftOf(depth_01.z),
                                           ivec2(int(depth_2.z), depthMaxOf(depth_2.w)), tile_size);
        ListEntries(args.lists).at[at] = entry;
      }
    }
    if (!finds_emitters || reached.y < 0) continue;
    atomicMax(Words(args.emitter_spans).at[2u * row], args.tiles_wide - uint(reached.x));
    atomicMax(Words(args.emitter_spans).at[2u * row + 1u], uint(reached.y) + 1u);
  }
}
