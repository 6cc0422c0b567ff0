// This part of meet.comp and of peel_blocked.comp counts the samples on which the fronts of two polygons look at each
// other, whatever lies between them. Each invocation has one polygon that may be the nearer of a pair. It goes through
// the polygons that may be the farther one; each invocation loads one of them, and shuffles pass it on. Where the
// ranges of their keys do not overlap, all samples that the two have in common count. Where they overlap, the keys are
// compared sample by sample. A pair of two-sided polygons counts in either order.

// A Party is a polygon with the samples that it covers, and the range of its keys there.
struct Party {
  uvec2 samples;           // as the including file defines them
  uint nearest, farthest;  // the least and the greatest Layer::key
  uint polygon;
  uint id;  // as in PolygonData::id
};

// Parties are the places [nearer, nearer_end) and [farther, farther_end) of two groups of parties, and their tile.
struct Parties {
  uint nearer, nearer_end;  // at most one for each invocation
  uint farther, farther_end;
  uint direction, weight;  // index and weight of the tile's direction
  ivec2 corner;            // the tile's least lattice column and row
};

// The including file defines these four functions, for its kind of samples. The first returns the party at a place; the
// next two return whether, and how many, samples two parties have in common.
Party fetchParty(uint place, uint direction, ivec2 corner);
bool haveCommon(uvec2 samples, uvec2 others);
uint countCommon(uvec2 samples, uvec2 others);
// Returns the number of common samples on which polygon `nearer` comes before polygon `farther`.
//   In: nearer, farther: their depth planes    Out: cut: true where the device ended a loop before its condition was
//     false
uint countInOrder(uvec2 samples, uvec2 others, DepthPlane nearer, DepthPlane farther, inout bool cut);

// Returns the party at a place with its id, or, from `end` on, a party without samples.
Party fetchPartyBefore(uint place, uint end, uint direction, ivec2 corner) {
  Party party = fetchParty(min(place, end - 1u), direction, corner);
  party.id = kIdsAreIndices ? party.polygon : fetchId(party.polygon);
  if (place >= end) party.samples = uvec2(0);
  return party;
}

// Returns a bit for each of the farther polygons of lanes `eight` to eight + 7. It is set where the polygon has samples
// in common with the nearer one and its keys are greater on all of them. With `doubtful` it is set instead where the
// keys may be greater on some samples, but need not be on all. For two-sided polygons, whose order does not matter, it
// is set where the farther polygon stands behind the nearer one in the list.
//   In: place: the nearer polygon's place; farther_place: the place of lane 0's farther polygon
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

// Counts the pairs of a nearer and a farther party: the pairs whose ranges of keys do not overlap or, with
// `doubtful`, the pairs whose ranges overlap (see findMeeting).
//   Out: steps: raised by the number of turns of the inner loops; cut: see countInOrder
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
    do {  // skips groups of eight parties in which no invocation has one to count
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
