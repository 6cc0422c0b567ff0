#version 460
// One workgroup, meant to be one subgroup, takes one meeting: on how many samples of a tile two polygons face each other, whatever is between them. Each invocation
// has one of the nearer polygons and goes through the farther ones, which are loaded one by each and passed on by shuffles. Samples that both
// cover are common bits. Where their depths over the tile leave no doubt which of the two is nearer that is all; otherwise each common sample
// is looked at. Of two-sided polygons the order does not matter.
//   In: meetings, covers, cover_polygons, active_tiles, projected, polygons     Out: counters
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
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
layout(push_constant, scalar) uniform Args { MeetArgs args; };

// A polygon's cover and what it counts for.
struct Party {
  uvec2 samples;
  uint nearest, farthest;
  uint polygon;
  uint id;  // and roles, where they matter
};

Party fetchParty(uint place, bool is_one) {
  uvec4 texel = texelFetch(cover_texels, int(place));
  Party party;
  party.samples = is_one ? texel.xy : uvec2(0);
  party.nearest = texel.z;
  party.farthest = texel.w;
  party.polygon = texelFetch(list_texels, int(place)).x;
  party.id = kIdsAreIndices ? party.polygon : fetchId(party.polygon);
  return party;
}

// Of the eight farther polygons from `eight` on, a bit each: those that share samples with the nearer one and lie behind it all over the tile, or,
// where `doubtful`, may lie behind it.
uint findMet(Party nearer, Party farther, uint eight, uint place, uint farther_place, bool doubtful) {
  uint met = 0u;
  [[unroll]] for (uint t = 0u; t < 8u; ++t) {
    uvec2 common_samples = nearer.samples & subgroupShuffle(farther.samples, eight + t);
    bool meets = (common_samples.x | common_samples.y) != 0u;
    if (kTwoSided) {
      meets = meets && farther_place + eight + t > place;
    } else {
      bool is_behind = nearer.farthest <= subgroupShuffle(farther.nearest, eight + t);
      bool may_be_behind = nearer.nearest <= subgroupShuffle(farther.farthest, eight + t);
      meets = meets && (doubtful ? may_be_behind && !is_behind : is_behind);
    }
    met |= meets ? 1u << t : 0u;
  }
  return met;
}

// How many of the samples the nearer polygon is nearer at; at equal depths fronts that face +u come first.
uint countInOrder(uvec2 samples, DepthPlane nearer, DepthPlane farther, inout bool cut) {
  uint count = 0u;
  do {
    uint bit = samples.x != 0u ? uint(findLSB(samples.x)) : 32u + uint(findLSB(samples.y));
    ivec2 in_tile = ivec2(bit % kTileWidth, bit / kTileWidth);
    bool is_one = (samples.x | samples.y) != 0u;
    count += is_one && depthAt(nearer, in_tile) <= depthAt(farther, in_tile) ? 1u : 0u;
    if (samples.x != 0u) samples.x &= samples.x - 1u;
    else samples.y &= samples.y - 1u;
  } while ((samples.x | samples.y) != 0u);
  cut = cut || (samples.x | samples.y) != 0u;
  return count;
}

// Adds up what meets: without doubt, or in doubt. cut: whether a loop ended before its time.
void addMet(Meeting meeting, uvec4 tile, ivec2 corner, uint from, uint to, bool doubtful, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID;
  uint place = min(meeting.nearer + lane, meeting.nearer_end - 1u);
  Party nearer = fetchParty(place, meeting.nearer + lane < meeting.nearer_end);
  uint first_projected = 4u * tile.z * args.polygon_count;
  DepthPlane nearer_plane;
  if (doubtful) nearer_plane = fetchDepthPlane(first_projected + 4u * nearer.polygon, corner);
  Counters counters = Counters(args.counters, args.status, args.id_count, args.counter_mask, kSparse, 2u);
  uint base = from, eight = 0u;
  Party farther = fetchParty(min(base + lane, to - 1u), base + lane < to);
  do {
    uint met, met_eight, met_base;
    Party met_farther;
    do {  // on to the next eight among which some lane meets one
      met = findMet(nearer, farther, eight, place, base, doubtful);
      met_farther = farther;
      met_eight = eight;
      eight += 8u;
      if (eight >= lanes) {
        eight = 0u;
        base += lanes;
        farther = fetchParty(min(base + lane, to - 1u), base + lane < to);
      }
    } while (base < to && !subgroupAny(met != 0u));
    do {
      uint t = met_eight + (met != 0u ? uint(findLSB(met)) : 0u);
      uvec2 samples = nearer.samples & subgroupShuffle(met_farther.samples, t);
      uint farther_id = subgroupShuffle(met_farther.id, t);
      bool is_one = met != 0u && (kAllCount || exchange(nearer.id >> kRolesShift, farther_id >> kRolesShift));
      uint count = uint(bitCount(samples.x) + bitCount(samples.y));
      if (doubtful) {
        uint farther_polygon = subgroupShuffle(met_farther.polygon, t);
        count = countInOrder(is_one ? samples : uvec2(0), nearer_plane, fetchDepthPlane(first_projected + 4u * farther_polygon, corner), cut);
      }
      if (is_one && count > 0u)
        addCount(counters, kFacingOrBlocked, pairOf(kGapFacingPair, nearer.id & kIdMask, farther_id & kIdMask), uint64_t(count) * uint64_t(tile.w));
      met &= met - 1u;
    } while (subgroupAny(met != 0u));
    cut = cut || met != 0u;
  } while (base < to);
  cut = cut || base < to;
}

void main() {
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  Status status = Status(args.status);
  if (place >= status.at.meetings) return;
  Meeting meeting = Meetings(args.meetings).at[place];
  uint from = meeting.farther + gl_WorkGroupID.z * kMostFarther, to = min(from + kMostFarther, meeting.farther_end);
  if (from >= to) return;
  uvec4 tile = texelFetch(tile_texels, int(2u * meeting.tile));  // list_start, list_length, direction, weight
  ivec2 corner = ivec2(texelFetch(tile_texels, int(2u * meeting.tile + 1u)).xy);
  bool cut = false;
  addMet(meeting, tile, corner, from, to, false, cut);
  if (!kTwoSided) addMet(meeting, tile, corner, from, to, true, cut);
  if (cut) atomicOr(status.at.overflows, kLoopCut);
}
