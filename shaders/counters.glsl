// Counters of pairs of ids have 64 bits each. They form a dense triangle, or an open-addressing hash table of the pairs
// with counts. A pair has one counter, of facing lines. Where blocked pairs are counted it has a second one: of all
// lines on which the two fronts look at each other, blocked or not.
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer Counter { uint64_t value; };

const uint kMostProbes = 256u;  // places of the hash table that are tried for a pair

// A gap counts for a pair (x, y) of ids with x <= y, or for the environment or leak of id x: then y is one of the
// two columns below.
const uint kEnvironmentColumn = 0xFFFFFFFEu;
const uint kLeakColumn = 0xFFFFFFFFu;

// Returns the pair that a gap counts for.
//   In: gap: by classifyGap, other than kGapNothing
uvec2 pairOf(uint gap, uint lower_id, uint upper_id) {
  if (gap == kGapFacingPair) return uvec2(min(lower_id, upper_id), max(lower_id, upper_id));
  bool of_lower = gap == kGapLowerEnvironment || gap == kGapLowerLeak;
  return uvec2(of_lower ? lower_id : upper_id,
               gap == kGapLowerLeak || gap == kGapUpperLeak ? kLeakColumn : kEnvironmentColumn);
}

// A pair has these counters.
const uint kFacing = 0u;
const uint kFacingOrBlocked = 1u;

struct Counters {
  // This is the address of the dense triangle, uint64_t[][per_pair], or of the hash table, uint64_t[mask + 1][1 +
  // per_pair]. A place of the table has the pair's one's complement, 0 where it is free, and its counters.
  uint64_t at;
  uint64_t status;  // BatchStatus
  uint id_count;
  uint mask;      // places of the hash table - 1
  bool sparse;    // whether there is a hash table
  uint per_pair;  // counters of a pair, 1 or 2
};

// Adds `weight` to the counter `which` of a pair. Where the hash table has no place for the pair, it sets
// kCountersOverflowed in the status.
void addCount(Counters counters, uint which, uvec2 pair, uint64_t weight) {
  if (!counters.sparse) {
    uint column = pair.y >= kEnvironmentColumn ? counters.id_count + (pair.y - kEnvironmentColumn) : pair.y;
    uint64_t index = counterIndex(pair.x, column, counters.id_count) * uint64_t(counters.per_pair) + uint64_t(which);
    atomicAdd(Counter(counters.at + index * 8ul).value, weight);
    return;
  }
  uint64_t key = ~packUint2x32(pair.yx);
  // The pair's bits are mixed by odd multipliers, then by shifts, as in the finaliser of Appleby's MurmurHash3.
  uint at = pair.x * 0x9E3779B1u ^ pair.y * 0x85EBCA77u;
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
