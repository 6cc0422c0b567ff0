// Counters of pairs of ids, 64 bits each: a dense triangle, or an open-addressing hash table of the pairs met.
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer Counter { uint64_t value; };

const uint64_t kNoPair = ~0ul;
const uint kMostProbes = 256u;

// The gap of a line between two consecutive layers as a pair of ids: x <= y, or y kEnvironmentColumn or kLeakColumn.
const uint kEnvironmentColumn = 0xFFFFFFFEu;
const uint kLeakColumn = 0xFFFFFFFFu;

uvec2 pairOf(uint gap, uint lower_id, uint upper_id) {
  if (gap == kGapFacingPair) return uvec2(min(lower_id, upper_id), max(lower_id, upper_id));
  bool of_lower = gap == kGapLowerEnvironment || gap == kGapLowerLeak;
  return uvec2(of_lower ? lower_id : upper_id, gap == kGapLowerLeak || gap == kGapUpperLeak ? kLeakColumn : kEnvironmentColumn);
}

// Adds to the pair's counter. A hash table that has no place left says so in the status.
//   keys: uint64_t[mask + 1], kNoPair where free; counters: uint64_t[mask + 1], or the dense triangle
void addCount(uint64_t counters, uint64_t keys, uint mask, uint64_t status, uint id_count, bool sparse, uvec2 pair, uint weight) {
  if (!sparse) {
    uint column = pair.y >= kEnvironmentColumn ? id_count + (pair.y - kEnvironmentColumn) : pair.y;
    atomicAdd(Counter(counters + counterIndex(pair.x, column, id_count) * 8ul).value, uint64_t(weight));
    return;
  }
  uint64_t key = packUint2x32(pair.yx);
  uint at = pair.x * 0x9E3779B1u ^ pair.y * 0x85EBCA77u;  // mixed by odd multipliers, then by shifts (as in Appleby's finaliser)
  at ^= at >> 15;
  at *= 0x2C1B3C6Du;
  at ^= at >> 13;
  for (uint probe = 0u; probe < kMostProbes; ++probe) {
    at &= mask;
    uint64_t found = Counter(keys + uint64_t(at) * 8ul).value;
    if (found == kNoPair) found = atomicCompSwap(Counter(keys + uint64_t(at) * 8ul).value, kNoPair, key);
    if (found == kNoPair) atomicAdd(Status(status).at.pairs, 1u);
    if (found == kNoPair || found == key) {
      atomicAdd(Counter(counters + uint64_t(at) * 8ul).value, uint64_t(weight));
      return;
    }
    ++at;
  }
  atomicOr(Status(status).at.overflows, kCountersOverflowed);
}
