// Part of meet.comp and, with scanlines, of peel_blocked.comp: it counts the samples on which two polygons face each
// other, whatever is between them. Each invocation has one of the polygons that may be the nearer. It goes through the
// polygons that may be the farther, which are loaded one by each and passed on by shuffles. Where the depths of two
// leave no doubt which is nearer, all samples that they have in common count. Otherwise each of these samples is looked
// at. Of two-sided polygons the order does not matter.

// A Party is a polygon, the samples of the tile or row that it covers, and how its depth ranges there.
struct Party {
  uvec2 samples;
  uint nearest, farthest;  // keys, see Layer
  uint polygon;
  uint id;  // and roles, where they matter
};

// Who meets: places of parties; and the tile.
struct Parties {
  uint nearer, nearer_end;  // as many as there are invocations, or fewer
  uint farther, farther_end;
  uint direction, weight;
  ivec2 corner;
};

// The includer defines samples.
Party fetchParty(uint place, uint direction, ivec2 corner);
bool haveCommon(uvec2 samples, uvec2 others);
uint countCommon(uvec2 samples, uvec2 others);
// Returns the number of samples at which the nearer comes before the farther.
uint countInOrder(uvec2 samples, uvec2 others, DepthPlane nearer, DepthPlane farther, inout bool cut);

Party fetchPartyBefore(uint place, uint end, uint direction, ivec2 corner) {
  Party party = fetchParty(min(place, end - 1u), direction, corner);
  party.id = kIdsAreIndices ? party.polygon : fetchId(party.polygon);
  if (place >= end) party.samples = uvec2(0);
  return party;
}

// Returns a bit for each of the eight farther polygons from `eight` on. It is set where the polygon has samples in
// common with the nearer one and lies behind it on all of them. With `doubtful` it may also lie behind it on some.
uint findMeeting(Party nearer, Party farther, uint eight, uint place, uint farther_place, bool doubtful) {
  uint meeting = 0u;
  [[unroll]] for (uint t = 0u; t < 8u; ++t) {
    bool meets = haveCommon(nearer.samples, subgroupShuffle(farther.samples, eight + t));
    if (kTwoSided) {
      meets = meets && farther_place + eight + t > place;
    } else {
      bool is_behind = nearer.farthest < subgroupShuffle(farther.nearest, eight + t);
      bool may_be_behind = nearer.nearest <= subgroupShuffle(farther.farthest, eight + t);
      meets = meets && (doubtful ? may_be_behind && !is_behind : is_behind);
    }
    meeting |= meets ? 1u << t : 0u;
  }
  return meeting;
}

// Adds up the meetings that are without doubt, or in doubt.
void addMeeting(Parties parties, Counters counters, bool doubtful, inout uint steps, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID, place = parties.nearer + lane;
  Party nearer = fetchPartyBefore(place, parties.nearer_end, parties.direction, parties.corner);
  uint first_projected = parties.direction * args.polygon_count;
  DepthPlane nearer_plane;
  if (doubtful) nearer_plane = fetchDepthPlane(first_projected + nearer.polygon, parties.corner);
  uint base = parties.farther, eight = 0u;
  Party farther = fetchPartyBefore(base + lane, parties.farther_end, parties.direction, parties.corner);
  do {
    uint meeting, meeting_eight;
    Party meeting_farther;
    do {  // on to the next eight among which some invocation meets one
      meeting = findMeeting(nearer, farther, eight, place, base, doubtful);
      meeting_farther = farther;
      meeting_eight = eight;
      eight += 8u;
      if (eight >= lanes) {
        eight = 0u;
        base += lanes;
        farther = fetchPartyBefore(base + lane, parties.farther_end, parties.direction, parties.corner);
      }
      ++steps;
    } while (base < parties.farther_end && !anyOf(meeting != 0u));
    do {
      uint t = meeting_eight + (meeting != 0u ? uint(findLSB(meeting)) : 0u);
      uvec2 samples = subgroupShuffle(meeting_farther.samples, t);
      uint farther_id = subgroupShuffle(meeting_farther.id, t);
      bool is_one = meeting != 0u && (kAllCount || exchange(nearer.id >> kRolesShift, farther_id >> kRolesShift));
      uint count;
      if (doubtful) {
        uint farther_at = first_projected + subgroupShuffle(meeting_farther.polygon, t);
        count = countInOrder(is_one ? nearer.samples : uvec2(0), samples, nearer_plane,
                             fetchDepthPlane(farther_at, parties.corner), cut);
      } else {
        count = countCommon(nearer.samples, samples);
      }
      if (is_one && count > 0u)
        addCount(counters, kFacingOrBlocked, pairOf(kGapFacingPair, nearer.id & kIdMask, farther_id & kIdMask),
                 uint64_t(count) * uint64_t(parties.weight));
      meeting &= meeting - 1u;
      ++steps;
    } while (anyOf(meeting != 0u));
    cut = cut || meeting != 0u;
  } while (base < parties.farther_end);
  cut = cut || base < parties.farther_end;
}
