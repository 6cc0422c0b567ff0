#version 460
// One workgroup, meant to be one subgroup, peels some rows of one tile: each invocation takes one lattice point and keeps the kLayersKept nearest layers
// behind those of the round before in registers; it adds what the gaps between consecutive layers contribute to the counters, and goes
// round again where more layers may remain. The polygons of the tile's list are loaded one by each invocation and passed on by shuffles.
//   In: active_tiles, lists, projected, edges, polygons    Out: counters
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "geometry.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;
layout(push_constant, scalar) uniform Args { PeelTilesArgs args; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Counter { uint value; };

const uint64_t kNoLayer = ~0ul;  // a layer is key << 32 | polygon + 1, so that layers are ordered as numbers
const int kSaturated = 1 << 30;  // beyond what an edge can change by within a tile

uint sideOf(uint64_t layer, bool above) {
  if (layer == 0ul || layer == kNoLayer) return kSideNone;
  return sideTowardsGap((layer >> 32 & 1ul) == 0ul, args.two_sided != 0u, above);
}

uint idOf(uint64_t layer) { return Polygons(args.polygons).at[uint(layer) - 1u].id; }

void addGap(uint64_t lower, uint64_t upper) {
  uint gap = classifyGap(sideOf(lower, true), sideOf(upper, false));
  if (gap == kGapNothing) return;
  bool has_lower = gap == kGapFacingPair || gap == kGapLowerEnvironment || gap == kGapLowerLeak;
  uint i = idOf(has_lower ? lower : upper);
  uint column = args.id_count + (gap == kGapLowerLeak || gap == kGapUpperLeak ? 1u : 0u);
  if (gap == kGapFacingPair) {
    uint j = idOf(upper);
    column = max(i, j);
    i = min(i, j);
  }
  atomicAdd(Counter(args.counters + counterIndex(i, column, args.id_count) * 4ul).value, 1u);
}

void main() {
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  if (place >= args.active_tile_count) return;
  uint tile = Words(args.active_tiles).at[2u * place], count = Words(args.active_tiles).at[2u * place + 1u];
  uint start = Words(args.tile_starts).at[tile];
  uint tiles_per_direction = args.tiles_per_side * args.tiles_per_side;
  uint direction_index = tile / tiles_per_direction, in_direction = tile % tiles_per_direction;
  ivec2 origin = ivec2(in_direction % args.tiles_per_side, in_direction / args.tiles_per_side) * kTileSize -
                 int(args.tiles_per_side) * kTileSize / 2;
  uint lane = gl_SubgroupInvocationID, lanes = gl_SubgroupSize;
  int point = int(gl_WorkGroupID.z * gl_WorkGroupSize.x + gl_LocalInvocationID.x);  // of the tile
  int column = point % kTileSize, row = point / kTileSize;

  uint64_t last = 0ul;  // the farthest layer of the rounds before
  bool open = true;    // whether the line may meet more layers
  bool truncated = false;
  do {
    uint64_t nearest[kLayersKept];
    for (int k = 0; k < kLayersKept; ++k) nearest[k] = kNoLayer;
    uint scanned = 0u;
    for (uint base = 0u; base < count; base += lanes) {
      // This invocation's polygon, moved to the tile's corner.
      uint polygon_index = Words(args.lists).at[start + min(base + lane, count - 1u)];
      ProjectedPolygon polygon = Projected(args.projected).at[direction_index * args.polygon_count + polygon_index];
      PolygonData data = Polygons(args.polygons).at[polygon_index];
      uint edge_at = direction_index * args.corner_count + data.first_corner;
      ivec4 a, b, c;
      for (uint k = 0u; k < 4u; ++k) {
        Edge edge = Edges(args.edges).at[edge_at + min(k, data.corner_count - 1u)];
        a[k] = edge.a;
        b[k] = edge.b;
        int64_t at_origin = int64_t(edge.a) * int64_t(origin.x) + int64_t(edge.b) * int64_t(origin.y) + edge.c;
        c[k] = int(clamp(at_origin, int64_t(-kSaturated), int64_t(kSaturated)));
      }
      int64_t depth = polygon.depth_0 + polygon.depth_x * int64_t(origin.x) + polygon.depth_y * int64_t(origin.y);
      ivec4 depth_01 = ivec4(unpack32(depth), unpack32(polygon.depth_x));
      ivec4 depth_2 = ivec4(unpack32(polygon.depth_y), polygon.depth_min, polygon.depth_max);
      ivec4 rest = ivec4(int(polygon_index + 1u), 2 * polygon.depth_shift + int(polygon.front_up), int(edge_at), int(data.corner_count));
      for (uint t = 0u; t < min(count - base, lanes); ++t, ++scanned) {
        ivec4 edges = subgroupShuffle(a, t) * column + subgroupShuffle(b, t) * row + subgroupShuffle(c, t);
        ivec4 d01 = subgroupShuffle(depth_01, t), d2 = subgroupShuffle(depth_2, t), other = subgroupShuffle(rest, t);
        bool covered = (edges.x | edges.y | edges.z | edges.w) >= 0;
        int edge = 4;
        for (; edge < other.w; ++edge) covered = covered && isInside(Edges(args.edges).at[uint(other.z + edge)], origin + ivec2(column, row));
        truncated = truncated || edge < other.w;
        int64_t z = (pack64(d01.xy) + pack64(d01.zw) * int64_t(column) + pack64(d2.xy) * int64_t(row)) >> (other.y >> 1);
        uint key = 2u * uint(clamp(z, int64_t(d2.z), int64_t(d2.w))) + (1u - (uint(other.y) & 1u));
        uint64_t layer = uint64_t(key) << 32 | uint64_t(uint(other.x));
        layer = covered && layer > last ? layer : kNoLayer;
        for (int k = 0; k < kLayersKept; ++k) {
          uint64_t farther = max(nearest[k], layer);
          nearest[k] = min(nearest[k], layer);
          layer = farther;
        }
      }
    }
    uint64_t lower = last;
    for (int k = 0; k < kLayersKept; ++k) {
      if (open) addGap(lower, nearest[k]);
      open = open && nearest[k] != kNoLayer;
      lower = nearest[k] != kNoLayer ? nearest[k] : lower;
    }
    last = lower;
    truncated = truncated || scanned < count;
  } while (subgroupAny(open));
  if (truncated || open) atomicOr(Status(args.status).at.truncated, 1u);
}
