#version 460
// One invocation takes one polygon along one direction. Where the polygon's box holds few lattice points, the
// invocation tests each and stores a fragment, which is a finished layer, at each point that the polygon covers. Peel
// then need not test this polygon against the other points of its tile. All other polygons are listed for the passes
// over tiles.
//   In: directions, polygons, corners     Out: fragments, fragment_counts; listed
//   Source: Carpenter, "The A-buffer, an antialiased hidden surface method" (1984).
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "projection.glsl"

layout(constant_id = 0) const uint kTileWidth = 8u;
layout(constant_id = 1) const uint kTileRows = 8u;

void main() {
  args = pushed;
  uint polygon_index = gl_GlobalInvocationID.x, direction_index = gl_WorkGroupID.y;
  if (polygon_index >= args.polygon_count) return;
  Projection found = projectPolygon(polygon_index, direction_index);
  ProjectedPolygon polygon = found.polygon;
  ivec2 size = polygon.box_max - polygon.box_min + 1;
  bool few = size.x <= int(kMostTileWidth) && size.y <= int(kMostTileRows) && size.x * size.y <= int(args.few_points);
  if (!found.covers_none && !few) listPolygon(direction_index * args.polygon_count + polygon_index);

  // All covered points of the box are found before the first fragment is stored, because storing takes far longer than
  // testing. Bit row * kMostTileWidth + column of `covered` is set where the polygon covers the point.
  ivec4 a, b, row;  // values of the four edges: change per column, change per row, value at the row's first point
  for (uint k = 0u; k < 4u; ++k) {
    a[k] = found.edges[k].a;
    b[k] = found.edges[k].b;
    row[k] = valueAtCorner(found.edges[k], polygon.box_min);
  }
  ivec4 edges = row;
  uint64_t covered = 0ul;
  int x = 0, first_bit = 0;
  for (int left = few && !found.covers_none ? size.x * size.y : 0; left > 0; --left) {
    bool inside = (edges.x | edges.y | edges.z | edges.w) >= 0;
    covered |= inside ? 1ul << (first_bit + x) : 0ul;
    ++x;
    bool row_ends = x == size.x;
    row += row_ends ? b : ivec4(0);
    edges = row_ends ? row : edges + a;
    first_bit += row_ends ? int(kMostTileWidth) : 0;
    x = row_ends ? 0 : x;
  }

  int64_t depth_x = depthXOf(polygon.depth_x_packed),
          depth_at_corner =
              polygon.depth_0 + depth_x * int64_t(polygon.box_min.x) + polygon.depth_y * int64_t(polygon.box_min.y);
  uvec2 in_grid = uvec2(polygon.box_min + ivec2(args.tiles_wide * kTileWidth, args.tiles_high * kTileRows) / 2);
  uint first_tile = direction_index * args.tiles_high * args.tiles_wide;
  uvec2 bits = unpackUint2x32(covered);
  while ((bits.x | bits.y) != 0u) {
    uint bit = bits.x != 0u ? uint(findLSB(bits.x)) : 32u + uint(findLSB(bits.y));
    bits.y &= bits.x != 0u ? ~0u : bits.y - 1u;
    bits.x &= bits.x - 1u;
    uvec2 in_box = uvec2(bit % kMostTileWidth, bit / kMostTileWidth), p = in_grid + in_box;
    uint tile = first_tile + p.y / kTileRows * args.tiles_wide + p.x / kTileWidth;
    uint point = tile * (kTileWidth * kTileRows) + p.y % kTileRows * kTileWidth + p.x % kTileWidth;
    uint slot = atomicAdd(Words(args.fragment_counts).at[point], 1u);
    uint key = layerKeyOf(depth_at_corner + depth_x * int64_t(in_box.x) + polygon.depth_y * int64_t(in_box.y), polygon);
    if (slot < args.fragment_capacity)
      Longs(args.fragments).at[slot * args.point_count + point] =
          packUint2x32(uvec2(packLayerPolygon(polygon_index, frontUpOf(uint(polygon.depth_x_packed))), key));
  }
}
