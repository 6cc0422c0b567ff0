// This part of peel.glsl adds the gaps between the layers of a line to the counters.

// Returns whether a gap counts, by the roles of the polygons around it.
//   In: gap: by classifyGap; lower, upper: ids with roles, as in PolygonData::id
bool isCounted(uint gap, uint lower, uint upper) {
  if (kAllCount) return gap != kGapNothing;
  uint lower_roles = lower >> kRolesShift, upper_roles = upper >> kRolesShift;
  if (gap == kGapFacingPair) return exchange(lower_roles, upper_roles);
  if (gap == kGapNothing || args.counts_environment == 0u) return false;
  return ((gap == kGapLowerEnvironment || gap == kGapLowerLeak ? lower_roles : upper_roles) & kEmits) != 0u;
}

// Returns a polygon's id with its roles.
//   In: layer_polygon: index + 1, or 0 for no polygon
uint idOf(uint layer_polygon) {
  if (layer_polygon == 0u) return 0u;
  return kIdsAreIndices ? layer_polygon - 1u : fetchId(layer_polygon - 1u);
}

Counters peelCounters() {
  return Counters(args.counters + uint64_t(block) * args.block_bytes, args.status, args.id_count, args.counter_mask,
                  kSparse, kCountsBlocked ? 2u : 1u);
}

// Adds each lane's weight to its pair's counter. Where neighbouring lanes have the same pair, the first of these lanes
// adds the sum of their weights.
//   In: has: whether this lane adds anything
void addRuns(bool has, uvec2 pair, uint weight, uint lane) {
  if (kAggregates) {
    const uint lanes = gl_WorkGroupSize.x;
    uvec2 key = has ? pair : uvec2(~0u);
    uvec2 before = subgroupShuffle(key, max(lane, 1u) - 1u);
    bool head = lane == 0u || key != before;
    // A run of lanes with one pair ends where the next run begins.
    uint end = subgroupShuffle(head ? lane : lanes, min(lane + 1u, lanes - 1u));
    if (lane + 1u == lanes) end = lanes;
    uint all, sum = sumSoFar(weight, all);
    end = leastFrom(end);
    uint to_end = subgroupShuffle(sum, end - 1u);
    has = has && head;
    weight = to_end - sum + weight;
  }
  if (has) addCount(peelCounters(), kFacing, pair, uint64_t(weight));
}

// Adds gaps of one sample of each lane to the counters: the gap below each layer that is nearer than `bound`. Where the
// list has ended and every layer found room, it also adds the gap above the last layer. Gaps that count are collected
// first, for on lines through closed solids only every other gap counts. Returns their number. In: before: the last
// layer that has been added, or 0; at_end: whether the list has ended; is_open: whether the sample may have layers Out:
// before: the last layer that has been added now
uint addGaps(inout uint64_t before, uint64_t layers[kLayersKept], uint64_t bound, bool at_end, bool is_open,
             uint weight, uint lane, inout bool cut) {
  // A gap's lower and upper polygon are held as index + 1, or 0 for none, | kBackMark where no front faces the gap.
  uvec2 found[kLayersKept + 1];
  uint count = 0u;
  [[unroll]] for (int k = 0; k <= kLayersKept; ++k) found[k] = uvec2(0);
  [[unroll]] for (int k = 0; k <= kLayersKept; ++k) {
    uint64_t upper = k < kLayersKept ? layers[k] : kNoLayer;
    is_open = is_open && (upper < bound || (at_end && bound == kNoLayer));
    bool lower_front = before != 0ul && (kTwoSided || !isFrontDown(unpackUint2x32(before).x));
    bool upper_front = upper != kNoLayer && (kTwoSided || isFrontDown(unpackUint2x32(upper).x));
    uvec2 gap = uvec2(layerPolygonOf(unpackUint2x32(before).x),
                      upper == kNoLayer ? 0u : layerPolygonOf(unpackUint2x32(upper).x));
    gap |= uvec2(lower_front ? 0u : kBackMark, upper_front ? 0u : kBackMark);
    bool counted = is_open && (lower_front || upper_front);
    [[unroll]] for (int m = 0; m <= k; ++m) found[m] = counted && count == uint(m) ? gap : found[m];
    count += counted ? 1u : 0u;
    is_open = is_open && upper != kNoLayer;
    before = is_open ? upper : before;
  }
  uint added = 0u, left = count;
  while (anyOf(left > 0u)) {
    uvec2 gap = found[0];
    [[unroll]] for (int k = 0; k < kLayersKept; ++k) found[k] = found[k + 1];
    bool has = left > 0u;
    left -= has ? 1u : 0u;
    uint lower_side = (gap.x & ~kBackMark) == 0u ? kSideNone : (gap.x & kBackMark) != 0u ? kSideBack : kSideFront;
    uint upper_side = (gap.y & ~kBackMark) == 0u ? kSideNone : (gap.y & kBackMark) != 0u ? kSideBack : kSideFront;
    uint kind = classifyGap(lower_side, upper_side);
    uint lower_id = idOf(gap.x & ~kBackMark), upper_id = idOf(gap.y & ~kBackMark);
    has = has && isCounted(kind, lower_id, upper_id);
    addRuns(has, pairOf(kind, lower_id & kIdMask, upper_id & kIdMask), weight, lane);
    added += has ? 1u : 0u;
  }
  cut = cut || left > 0u;
  return added;
}

// Adds the gaps of all samples of the invocation, as addGaps does, below all layers that are nearer than `bound`. No
// layer that is still to come can lie in one of these gaps. With sorted lists it then removes the added layers from
// `nearest`, to make room. Returns the number of gaps that were counted.
uint flush(uint64_t bound, bool at_end, uint weight, uint lane, inout bool cut) {
  uint gaps = 0u;
  int s = 0;
  do {
    uint64_t layers[kLayersKept];
    [[unroll]] for (int k = 0; k < kLayersKept; ++k) layers[k] = nearest[0][k];
    uint64_t before = last[0], its_bound = min(bound, lost[0]);
    bool is_open = open[0];
    [[unroll]] for (int m = 1; m < kMostSteps; ++m) {
      if (m >= kSteps) continue;
      [[unroll]] for (int k = 0; k < kLayersKept; ++k) layers[k] = s == m ? nearest[m][k] : layers[k];
      before = s == m ? last[m] : before;
      its_bound = s == m ? min(bound, lost[m]) : its_bound;
      is_open = s == m ? open[m] : is_open;
    }
    gaps += addGaps(before, layers, its_bound, at_end, is_open, weight, lane, cut);
    if (kSorted) {
      [[unroll]] for (int k = 0; k < kLayersKept; ++k) {  // removes the layers that have been added
        bool first_gone = layers[0] <= before && layers[0] < its_bound;
        [[unroll]] for (int m = 0; m < kLayersKept; ++m) layers[m] =
            first_gone ? m + 1 < kLayersKept ? layers[m + 1] : kNoLayer : layers[m];
      }
    }
    [[unroll]] for (int m = 0; m < kMostSteps; ++m) {
      last[m] = s == m ? before : last[m];
      if (kSorted) {
        [[unroll]] for (int k = 0; k < kLayersKept; ++k) nearest[m][k] = s == m ? layers[k] : nearest[m][k];
      }
    }
    ++s;
  } while (s < kSteps);
  cut = cut || s < kSteps;
  return gaps;
}
