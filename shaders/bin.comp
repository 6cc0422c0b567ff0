#version 460
// One invocation takes one listed polygon in one direction, and some rows of tiles, and finds the tiles that it can
// cover samples of. Its mode says why: to note its roles there, to count the polygons of tiles, or, with lists
// allocated, to enter itself. Where only some polygons count, nothing outside a row's span of tiles with emitters is
// looked at: long thin emitters leave most of a fine window empty.
//   In: listed, projected, corners
//   Out, by mode: tile_roles, emitter_spans; tile_counts; lists (tile_counts is counted down to 0)
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kMode = kBinCount;
layout(constant_id = 1) const bool kNeedsRoles = false;  // of an active tile: args.needed_roles
layout(constant_id = 2) const bool kSorts = false;
layout(constant_id = 3) const uint kTileWidth = 8u;
layout(constant_id = 4) const uint kTileRows = 8u;
layout(constant_id = 5) const int kColumnBits = 0;
layout(constant_id = 6) const int kCutBits = 0;  // see makeEdge
layout(push_constant, scalar) uniform Args { BinArgs pushed; };
BinArgs args;

const int kWideBox = 16;  // tiles, from which on a row's span pays for its divisions

// Returns the columns of tiles in one row, from span.x to span.y, that an edge may reach: all where reach + per_column
// x >= 0, rounded outward. Floats are off by 2^-22 of a quotient at most, which is below 2^13 here, so by
// less than the half tile that is added.
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

  // The largest values of the edges over a tile are at the grid's first tile here, with their changes from tile to
  // tile.
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
