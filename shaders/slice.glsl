// Part of peel.glsl: with scanlines, it finds the samples of some rows.

// Returns a polygon's part in a row: first | last - first << kPositionBits.
uint spanOf(ivec2 corner, uint row, SnappedCorners corners) {
  int low = 0, high = int(kRowWidth);
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    Edge edge = makeEdge(corners, k, kCutBits);
    int64_t value = int64_t(edge.a) * int64_t(corner.x << kColumnBits) +
                    (int64_t(edge.b) * int64_t(corner.y + int(row)) << kColumnBits) + edge.c;
    cutRow(edge, value, int(kRowWidth), low, high);
  }
  return low < high ? row * kRowWidth + uint(low) | uint(high - low - 1) << kPositionBits : kNoColumns;
}

// Returns where span k is: the first `ups` from the beginning, the others from the end.
uint placeOfSpan(uint k, uint ups) { return kCountsBlocked && k >= ups ? kMostSpans - 1u - (k - ups) : k; }

// An end is in shared memory: its position | the number of spans that begin before it << kPositionBits + 1.
uint positionOf(uint end) { return end & (2u * kPositions - 1u); }
uint begunBefore(uint end) { return end >> kPositionBits + 1u; }

// Returns a span in `window`: its place in `spans` + its end * kMostSpans.
uint spanIn(uint entry) { return entry & kMostSpans - 1u; }
uint endIn(uint entry) { return entry / kMostSpans; }

// Returns a key that orders ends: of equal ones the earlier span's, and its left one, come first.
int endKey(uint position, uint span, uint side) { return int((position * kMostSpans + span) * 2u + side); }

// FoundSpans are the numbers of spans in the rows of a tile: of all, and of the ones that come first in `spans`. Each
// row has the number in earlier rows. Rows that hold a span are counted where work is measured.
struct FoundSpans {
  uint count, ups, held_rows;
  uint starts[kMostRowsAtOnce];  // only where no blocked pairs are counted
};

// Puts the rows' spans into shared memory, one row after another. Where blocked pairs are counted the spans of polygons
// whose fronts face +u come first, and the others stand at the end; of two-sided polygons all come first.
FoundSpans findSpans(Tile tile, uint lane, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  FoundSpans found;
  found.ups = found.held_rows = 0u;
  uint downs = 0u, base = 0u, held = 0u;
  [[unroll]] for (uint k = 0u; k < kMostRowsAtOnce; ++k) found.starts[k] = 0u;
  for (; base < tile.list_length * tile.rows; base += lanes) {
    uint row = 0u, mine = base + lane;  // all polygons in the first row, in the next
    [[unroll]] for (uint k = 1u; k < kMostRowsAtOnce; ++k) row +=
        mine >= k * tile.list_length && k < tile.rows ? 1u : 0u;
    mine -= row * tile.list_length;
    uint polygon = texelFetch(list_texels, int(tile.list_start + min(mine, tile.list_length - 1u))).x;
    uint projected = tile.direction * args.polygon_count + polygon,
         columns = spanOf(tile.corner, row, fetchCorners(projected));
    bool covers = mine < tile.list_length && columns != kNoColumns;
    bool is_up = !kCountsBlocked || kTwoSided ||
                 frontUpOf(texelFetch(projected_texels, int(kProjectedTexels * projected + 1u)).z) != 0u;
    uint all, so_far = sumSoFar(covers && is_up ? 1u : 0u, all), place = found.ups + so_far - 1u;
    found.ups += all;
    if (kCountsBlocked) {
      uint from_end = downs + sumSoFar(covers && !is_up ? 1u : 0u, all) - 1u;
      downs += all;
      place = is_up ? place : kMostSpans - 1u - from_end;
    } else {
      [[unroll]] for (uint k = 1u; k < kMostRowsAtOnce; ++k) {
        uint before = min(max(k * tile.list_length, base) - base, lanes),
             its = subgroupShuffle(so_far, max(before, 1u) - 1u);
        found.starts[k] += before == 0u ? 0u : its;
      }
    }
    held |= covers ? 1u << row : 0u;
    if (covers && place < kMostSpans) spans[place] = uvec2(polygon, columns);
  }
  cut = cut || base < tile.list_length * tile.rows;
  if (kMeasuresWork) [[unroll]]
    for (uint k = 0u; k < kMostRowsAtOnce; ++k) found.held_rows += anyOf((held >> k & 1u) != 0u) ? 1u : 0u;
  found.count = found.ups + downs;
  memoryBarrierShared();
  subgroupBarrier();
  return found;
}

// Ranks every end among all ends and puts it at its rank into `ends`, with the number of spans that begin before it.
// Puts the spans in order of where they begin into `window`.
void orderEnds(FoundSpans found, uint lane) {
  const uint lanes = gl_WorkGroupSize.x;
  for (uint base = 0u; base < found.count; base += lanes) {
    uint mine = base + lane;
    uint place = placeOfSpan(min(mine, found.count - 1u), found.ups), columns = spans[place].y;
    int low = endKey(firstOf(columns), mine, 0u), high = endKey(endOf(columns), mine, 1u);
    uint from = 0u, to = found.count;
    // Only spans of the rows of these spans are compared: all spans of earlier rows come before them.
    if (!kCountsBlocked) {
      [[unroll]] for (uint k = 1u; k < kMostRowsAtOnce; ++k) {
        if (found.starts[k] <= base) from = found.starts[k];
        if (found.starts[kMostRowsAtOnce - k] >= base + lanes) to = found.starts[kMostRowsAtOnce - k];
      }
    }
    // Spans that begin and that end before the low and the high end are counted.
    uint begin_low = from, end_low = from, begin_high = from, end_high = from;
    for (uint other_base = from; other_base < to; other_base += lanes) {
      uint other = other_base + lane;
      uint other_columns = spans[placeOfSpan(min(other, found.count - 1u), found.ups)].y;
      int other_low = other < to ? endKey(firstOf(other_columns), other, 0u) : kEndless;
      int other_high = other < to ? endKey(endOf(other_columns), other, 1u) : kEndless;
      [[unroll]] for (uint t = 0u; t < 8u; ++t) for (uint eight = 0u; eight < lanes; eight += 8u) {
        int a = subgroupShuffle(other_low, eight + t), b = subgroupShuffle(other_high, eight + t);
        begin_low += uint(a < low);
        end_low += uint(b < low);
        begin_high += uint(a < high);
        end_high += uint(b < high);
      }
    }
    if (mine < found.count) {
      ends[begin_low + end_low] = firstOf(columns) | begin_low << kPositionBits + 1u;
      ends[begin_high + end_high] = endOf(columns) | begin_high << kPositionBits + 1u;
      window[begin_low] = place + endOf(columns) * kMostSpans;
    }
  }
  memoryBarrierShared();
  subgroupBarrier();
}

// Keeps each position of the `end_count` ends once, the first of its ends. Returns how many are left.
uint keepPositions(uint end_count, uint lane, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  uint kept = 0u, last = ~0u, base = 0u;
  for (; base < end_count; base += lanes) {
    uint at = base + lane;
    uint end = ends[min(at, end_count - 1u)];
    uint before = subgroupShuffle(end, max(lane, 1u) - 1u);
    before = lane == 0u ? last : before;
    last = subgroupShuffle(end, lanes - 1u);
    bool keep = at < end_count && positionOf(end) != positionOf(before);
    uint all, place = kept + sumSoFar(keep ? 1u : 0u, all) - 1u;
    memoryBarrierShared();
    subgroupBarrier();
    if (keep) ends[place] = end;
    kept += all;
  }
  cut = cut || base < end_count;
  memoryBarrierShared();
  subgroupBarrier();
  return kept;
}

// Puts the rows' spans and their ends, each once and in order, into shared memory, and the spans in order of where they
// begin into `window`. Returns the numbers of spans, of spans that come first, of ends, and, where work is measured, of
// rows that hold a span. With more than kMostSpans spans it returns nothing but their number.
uvec4 sliceRows(Tile tile, uint lane, inout bool cut) {
  FoundSpans found = findSpans(tile, lane, cut);
  if (found.count > kMostSpans || found.count == 0u) return uvec4(found.count, found.ups, 0u, 0u);
  orderEnds(found, lane);
  return uvec4(found.count, found.ups, keepPositions(2u * found.count, lane, cut), found.held_rows);
}

// Moves the spans of `window` from `begin` to `end` that go on beyond a position to the end. Returns where they begin.
uint dropEnded(uint begin, uint end, uint position, uint lane, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  uint left = end - begin;
  do {
    uint entry = window[begin + max(left, lane + 1u) - lane - 1u];
    bool goes_on = lane < left && endIn(entry) > position;
    uint all, place = end - sumSoFar(goes_on ? 1u : 0u, all);
    memoryBarrierShared();
    subgroupBarrier();
    if (goes_on) window[place] = entry;
    end -= all;
    left -= min(left, lanes);
  } while (left > 0u);
  cut = cut || left > 0u;
  memoryBarrierShared();
  subgroupBarrier();
  return end;
}
