#version 460
// One workgroup, which has to be one subgroup, sorts the list of one tile by the polygons' nearest depths in the tile.
// Peel can then settle layers before it has seen the whole list. Each invocation finds the ranks of kRanked entries at
// a time, by comparing them with all entries. Lists of more than kMostSorted entries are copied unsorted, and their
// is_sorted is 0.
//   In: lists, projected     Out: sorted_lists; active_tiles: is_sorted
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(push_constant, scalar) uniform Args { SortArgs pushed; };
SortArgs args;

const int kRanked = 4;

void main() {
  args = pushed;
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID;
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  uint active_tiles = Status(args.status).at.active_tiles;
  if (place >= active_tiles || active_tiles >= kListsOverflowed) return;
  uvec2 list = texelFetch(tile_texels, int(kTileTexels * place)).xy;  // start, length
  bool sorts = list.y <= kMostSorted;
  uint compared_end = sorts ? list.y : 0u;
  uint done = 0u;
  do {
    uint64_t mine[kRanked];  // entries as nearest_depth << 32 | polygon
    uint rank[kRanked];
    [[unroll]] for (int k = 0; k < kRanked; ++k) {
      mine[k] = packUint2x32(
          texelFetch(list_texels, int(list.x + min(done + uint(k) * lanes + lane, max(list.y, 1u) - 1u))).xy);
      rank[k] = sorts ? 0u : done + uint(k) * lanes + lane;
    }
    for (uint base = 0u; base < compared_end; base += lanes) {
      uvec2 theirs = texelFetch(list_texels, int(list.x + min(base + lane, list.y - 1u))).xy;
      if (base + lane >= list.y) theirs = uvec2(~0u);
      uint t = 0u;
      do {
        [[unroll]] for (uint m = 0u; m < 4u; ++m) {
          uint64_t other = packUint2x32(subgroupShuffle(theirs, t + m));
          [[unroll]] for (int k = 0; k < kRanked; ++k) rank[k] += other < mine[k] ? 1u : 0u;
        }
        t += 4u;
      } while (t < lanes);
    }
    [[unroll]] for (int k = 0; k < kRanked; ++k) if (done + uint(k) * lanes + lane < list.y) Words(args.sorted_lists)
        .at[list.x + rank[k]] = unpackUint2x32(mine[k]).x;
    done += uint(kRanked) * lanes;
  } while (done < list.y);
  if (lane == 0u) ActiveTiles(args.active_tiles).at[place].is_sorted = sorts ? 1u : 0u;
}
