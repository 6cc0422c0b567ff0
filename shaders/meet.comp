#version 460
// One workgroup, which has to be one subgroup, takes one meeting (shared.h), or kMostFarther of its farther polygons.
// For every pair of a nearer and a farther polygon it counts the lattice points on which their fronts look at each
// other.
//   In: meetings, covers, cover_polygons, active_tiles, projected, polygons     Out: counters
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"
#include "counters.glsl"
layout(binding = 5) uniform usamplerBuffer cover_texels;  // Cover

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const uint kTileWidth = 8u;
layout(constant_id = 2) const bool kAllCount = true;
layout(constant_id = 3) const bool kTwoSided = false;
layout(constant_id = 4) const bool kSparse = false;
layout(constant_id = 5) const bool kIdsAreIndices = false;
layout(push_constant, scalar) uniform Args { MeetArgs pushed; };
MeetArgs args;

#include "subgroup.glsl"
#include "meetings.glsl"

// Party::samples are lattice points of the tile here, one bit each.
Party fetchParty(uint place, uint direction, ivec2 corner) {
  uvec4 cover = texelFetch(cover_texels, int(place));
  Party party;
  party.samples = cover.xy;
  party.nearest = cover.z;
  party.farthest = cover.w;
  party.polygon = texelFetch(list_texels, int(place)).x;
  return party;
}

bool haveCommon(uvec2 samples, uvec2 others) { return ((samples.x & others.x) | (samples.y & others.y)) != 0u; }

uint countCommon(uvec2 samples, uvec2 others) {
  return uint(bitCount(samples.x & others.x) + bitCount(samples.y & others.y));
}

uint countInOrder(uvec2 samples, uvec2 others, DepthPlane nearer, DepthPlane farther, inout bool cut) {
  uvec2 left = samples & others;
  uint count = 0u;
  do {
    bool is_one = (left.x | left.y) != 0u;
    uint bit = left.x != 0u ? uint(findLSB(left.x)) : 32u + uint(findLSB(left.y));
    ivec2 in_tile = ivec2(bit % kTileWidth, bit / kTileWidth);
    count += is_one && isBefore(nearer, depthAt(nearer, in_tile), farther, depthAt(farther, in_tile)) ? 1u : 0u;
    if (left.x != 0u) left.x &= left.x - 1u;
    else left.y &= left.y - 1u;
  } while ((left.x | left.y) != 0u);
  cut = cut || (left.x | left.y) != 0u;
  return count;
}

void main() {
  args = pushed;
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  Status status = Status(args.status);
  if (place >= status.at.meetings) return;
  Meeting meeting = Meetings(args.meetings).at[place];
  uvec4 tile = texelFetch(tile_texels, int(kTileTexels * meeting.tile));  // list_start, list_length, direction, weight
  Parties parties;
  parties.nearer = meeting.nearer;
  parties.nearer_end = meeting.nearer_end;
  parties.farther = meeting.farther + gl_WorkGroupID.z * kMostFarther;
  parties.farther_end = min(parties.farther + kMostFarther, meeting.farther_end);
  parties.direction = tile.z;
  parties.weight = tile.w;
  uvec4 corner = texelFetch(tile_texels, int(kTileTexels * meeting.tile + 1u));  // column, row, is_sorted, block
  parties.corner = ivec2(corner.xy);
  if (parties.farther >= parties.farther_end) return;
  Counters counters = Counters(args.counters + uint64_t(corner.w) * args.block_bytes, args.status, args.id_count,
                               args.counter_mask, kSparse, 2u);
  uint steps = 0u;
  bool cut = false;
  addMeeting(parties, counters, false, steps, cut);
  if (!kTwoSided) addMeeting(parties, counters, true, steps, cut);
  if (cut) atomicOr(status.at.overflows, kLoopCut);
}
