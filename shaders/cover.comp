#version 460
// One workgroup, which has to be one subgroup, takes one active tile, where blocked pairs are counted on lattice
// points. It writes a cover for each polygon of the tile: the lattice points that the polygon covers, and the range of
// its keys. Polygons that cover no point, or neither emit nor receive, get no cover. Covers of polygons whose fronts
// face +u fill the tile's range from its beginning, other covers from its end. The shader then makes meetings. Each
// takes up to a subgroup's size of polygons facing +u, as nearer ones, and all others, as farther ones. Two-sided
// polygons all stand at the beginning, and each meets the polygons behind it in the range.
//   In: active_tiles, lists, projected, corners, polygons     Out: covers, cover_polygons, meetings, status
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const uint kTileWidth = 8u;
layout(constant_id = 2) const bool kAllCount = true;
layout(constant_id = 3) const bool kTwoSided = false;
layout(constant_id = 4) const uint kTileRows = 8u;
layout(constant_id = 5) const int kCutBits = 0;  // see makeEdge
layout(push_constant, scalar) uniform Args { MeetArgs pushed; };
MeetArgs args;

#include "subgroup.glsl"

// Returns the lattice points of a tile that a polygon covers, see Cover::samples.
//   In: tile: the tile's least lattice column and row
uint64_t samplesOf(SnappedCorners corners, ivec2 tile) {
  ivec4 a, b, value;
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    Edge edge = makeEdge(corners, k, kCutBits);
    a[k] = edge.a;
    b[k] = edge.b;
    value[k] = valueAtCorner(edge, tile);
  }
  uint64_t samples = 0ul;
  for (uint row = 0u; row < kTileRows; ++row) {
    ivec4 at = value;
    uint bits = 0u;
    [[unroll]] for (uint column = 0u; column < kTileWidth; ++column) {
      bits |= (at.x | at.y | at.z | at.w) >= 0 ? 1u << column : 0u;
      at += a;
    }
    samples |= uint64_t(bits) << (row * kTileWidth);
    value += b;
  }
  return samples;
}

void main() {
  args = pushed;
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID;
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  Status status = Status(args.status);
  uint active_tiles = status.at.active_tiles;
  if (gl_NumSubgroups != 1u || place >= active_tiles || active_tiles >= kListsOverflowed) return;  // peel reports it
  uvec4 tile = texelFetch(tile_texels, int(kTileTexels * place));  // list_start, list_length, direction, weight
  ivec2 corner = ivec2(texelFetch(tile_texels, int(kTileTexels * place + 1u)).xy);
  uint ups = 0u, downs = 0u;
  for (uint base = 0u; base < tile.y; base += lanes) {
    uint mine = min(base + lane, tile.y - 1u);
    uint polygon = texelFetch(list_texels, int(tile.x + mine)).x;
    uint projected = tile.z * args.polygon_count + polygon;
    DepthPlane plane = fetchDepthPlane(projected, corner);
    Cover cover;
    cover.samples = samplesOf(fetchCorners(projected), corner);
    cover.nearest = nearestDepth(plane.at_corner, plane.per_column, plane.per_row, plane.shift, plane.range,
                                 ivec2(kTileWidth, kTileRows))
                        << kTieBits |
                    plane.place_at_tie;
    cover.farthest = farthestDepth(plane.at_corner, plane.per_column, plane.per_row, plane.shift, plane.range,
                                   ivec2(kTileWidth, kTileRows))
                         << kTieBits |
                     plane.place_at_tie;
    bool meets = base + lane < tile.y && cover.samples != 0ul && (kAllCount || fetchId(polygon) >> kRolesShift != 0u);
    bool is_up = kTwoSided || plane.front_up;
    uint kind = meets ? is_up ? 1u : 0x10000u : 0u;
    uint all, before = sumSoFar(kind, all) - kind;
    uint at = tile.x + (is_up ? ups + (before & 0xFFFFu) : tile.y - 1u - downs - (before >> 16));
    if (meets) {
      Covers(args.covers).at[at] = cover;
      Words(args.cover_polygons).at[at] = polygon;
    }
    ups += all & 0xFFFFu;
    downs += all >> 16;
  }
  uint farther = kTwoSided ? ups : downs, count = farther == 0u ? 0u : (ups + lanes - 1u) / lanes;
  if (count == 0u) return;
  uint first = 0u;
  if (lane == 0u) {
    first = atomicAdd(status.at.meetings, count);
    atomicMax(status.at.meet_groups.x, min(first + count, kGroupsPerRow));
    atomicMax(status.at.meet_groups.y, (first + count - 1u) / kGroupsPerRow + 1u);
    atomicMax(status.at.meet_groups.z, (farther + kMostFarther - 1u) / kMostFarther);
  }
  first = subgroupShuffle(first, 0u);
  for (uint k = lane; k < count; k += lanes) {
    Meeting meeting;
    meeting.tile = place;
    meeting.nearer = tile.x + k * lanes;
    meeting.nearer_end = tile.x + min((k + 1u) * lanes, ups);
    meeting.farther = kTwoSided ? tile.x : tile.x + tile.y - downs;
    meeting.farther_end = meeting.farther + farther;
    Meetings(args.meetings).at[first + k] = meeting;
  }
}
