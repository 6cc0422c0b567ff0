// Counters of pairs of ids, 64 bits each: a dense triangle, or an open-addressing hash table of the pairs met.
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer Counter { uint64_t value; };

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
//   counters: the dense triangle, uint64_t each, or mask + 1 places of two words, the one's complement of the pair (0: free) and the count
void addCount(uint64_t counters, uint mask, uint64_t status, uint id_count, bool sparse, uvec2 pair, uint weight) {
  if (!sparse) {
    uint column = pair.y >= kEnvironmentColumn ? id_count + (pair.y - kEnvironmentColumn) : pair.y;
    atomicAdd(Counter(counters + counterIndex(pair.x, column, id_count) * 8ul).value, uint64_t(weight));
    return;
  }
  uint64_t key = ~packUint2x32(pair.yx);
  uint at = pair.x * 0x9E3779B1u ^ pair.y * 0x85EBCA77u;  // mixed by odd multipliers, then by shifts (as in Appleby's finaliser)
  at ^= at >> 15;
  at *= 0x2C1B3C6Du;
  at ^= at >> 13;
  for (uint probe = 0u; probe < kMostProbes; ++probe) {
    at &= mask;
    uint64_t place = counters + uint64_t(at) * 16ul, found = Counter(place).value;
    if (found == 0ul) found = atomicCompSwap(Counter(place).value, 0ul, key);
    if (found == 0ul) atomicAdd(Status(status).at.pairs, 1u);
    if (found == 0ul || found == key) {
      atomicAdd(Counter(place + 8ul).value, uint64_t(weight));
      return;
    }
    ++at;
  }
  atomicOr(Status(status).at.overflows, kCountersOverflowed);
}
