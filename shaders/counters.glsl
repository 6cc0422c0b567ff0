// Counters of pairs of ids have 64 bits each: a dense triangle, or an open-addressing hash table of the pairs with
// counts. A pair has one of facing lines, or two: the second counts all lines on which the two face each other, blocked
// or not.
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer Counter { uint64_t value; };

const uint kMostProbes = 256u;

// The gap of a line between two consecutive layers is a pair of ids: x <= y, or y is kEnvironmentColumn or kLeakColumn.
const uint kEnvironmentColumn = 0xFFFFFFFEu;
const uint kLeakColumn = 0xFFFFFFFFu;

uvec2 pairOf(uint gap, uint lower_id, uint upper_id) {
  if (gap == kGapFacingPair) return uvec2(min(lower_id, upper_id), max(lower_id, upper_id));
  bool of_lower = gap == kGapLowerEnvironment || gap == kGapLowerLeak;
  return uvec2(of_lower ? lower_id : upper_id,
               gap == kGapLowerLeak || gap == kGapUpperLeak ? kLeakColumn : kEnvironmentColumn);
}

const uint kFacing = 0u;
const uint kFacingOrBlocked = 1u;

struct Counters {
  uint64_t at;      // the dense triangle, per_pair words each, or mask + 1 places of 1 + per_pair words: the one's
                    // complement of the pair (0: free), and counts
  uint64_t status;  // BatchStatus
  uint id_count;
  uint mask;
  bool sparse;
  uint per_pair;
};

// Adds to the pair's counter, kFacing or kFacingOrBlocked. A hash table that has no place left says so in the status.
void addCount(Counters counters, uint which, uvec2 pair, uint64_t weight) {
  if (!counters.sparse) {
    uint column = pair.y >= kEnvironmentColumn ? counters.id_count + (pair.y - kEnvironmentColumn) : pair.y;
    uint64_t index = counterIndex(pair.x, column, counters.id_count) * uint64_t(counters.per_pair) + uint64_t(which);
    atomicAdd(Counter(counters.at + index * 8ul).value, weight);
    return;
  }
  uint64_t key = ~packUint2x32(pair.yx);
  uint at = pair.x * 0x9E3779B1u ^
            pair.y * 0x85EBCA77u;  // mixed by odd multipliers, then by shifts (as in Appleby's finaliser)
  at ^= at >> 15;
  at *= 0x2C1B3C6Du;
  at ^= at >> 13;
  for (uint probe = 0u; probe < kMostProbes; ++probe) {
    at &= counters.mask;
    uint64_t place = counters.at + uint64_t(at) * uint64_t(8u + 8u * counters.per_pair), found = Counter(place).value;
    if (found == 0ul) found = atomicCompSwap(Counter(place).value, 0ul, key);
    if (found == 0ul) atomicAdd(Status(counters.status).at.pairs, 1u);
    if (found == 0ul || found == key) {
      atomicAdd(Counter(place + uint64_t(8u + 8u * which)).value, weight);
      return;
    }
    ++at;
  }
  atomicOr(Status(counters.status).at.overflows, kCountersOverflowed);
}
