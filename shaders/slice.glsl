// This part of peel.glsl finds the samples of scanlines: the spans of some rows, and their ends in order.

// Returns the span of a polygon in a row, first | (last - first) << kPositionBits, with the first and last position
// that it covers; kNoColumns where it covers none.
//   In: corner: the tile's least lattice column and row; row: its row in the tile
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

// Returns the place of span k in `spans`: the first `ups` spans stand at the beginning, the others from the end
// backward.
uint placeOfSpan(uint k, uint ups) { return kCountsBlocked && k >= ups ? kMostSpans - 1u - (k - ups) : k; }

// An entry of `ends` is an end's position | (the number of spans that begin before it) << (kPositionBits + 1).
uint positionOf(uint end) { return end & (2u * kPositions - 1u); }
uint begunBefore(uint end) { return end >> kPositionBits + 1u; }

// An entry of `window` is a span's place in `spans` + its end * kMostSpans.
uint spanIn(uint entry) { return entry & kMostSpans - 1u; }
uint endIn(uint entry) { return entry / kMostSpans; }

// Returns a key that orders ends by position. At one position the end of the earlier span comes first, and of one span
// the left end (side 0).
int endKey(uint position, uint span, uint side) { return int((position * kMostSpans + span) * 2u + side); }

// FoundSpans says how many spans the rows of a workgroup have: `count` in all, of which `ups` stand at the beginning of
// `spans`. Where work is measured, held_rows is the number of rows with any span.
struct FoundSpans {
  uint count, ups, held_rows;
  uint starts[kMostRowsAtOnce];  // spans in earlier rows, for each row; only where no blocked pairs are counted
};

// Writes the spans of the rows into `spans`, one row after another. Where blocked pairs are counted, only the spans of
// polygons whose fronts face +u stand at the beginning, and the others from the end backward. Spans of two-sided
// polygons all stand at the beginning.
FoundSpans findSpans(Tile tile, uint lane, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  FoundSpans found;
  found.ups = found.held_rows = 0u;
  uint downs = 0u, base = 0u, held = 0u;
  [[unroll]] for (uint k = 0u; k < kMostRowsAtOnce; ++k) found.starts[k] = 0u;
  for (; base < tile.list_length * tile.rows; base += lanes) {
    uint row = 0u, mine = base + lane;  // lanes take all polygons in the first row, then all in the next
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

// Writes every end, with the number of spans that begin before it, into `ends` at its rank among all ends. Writes the
// spans into `window` in the order in which they begin.
void orderEnds(FoundSpans found, uint lane) {
  const uint lanes = gl_WorkGroupSize.x;
  for (uint base = 0u; base < found.count; base += lanes) {
    uint mine = base + lane;
    uint place = placeOfSpan(min(mine, found.count - 1u), found.ups), columns = spans[place].y;
    int low = endKey(firstOf(columns), mine, 0u), high = endKey(endOf(columns), mine, 1u);
    uint from = 0u, to = found.count;
    // A lane's span is compared only with spans of its row: all spans of earlier rows come before it, and all spans of
    // later rows behind.
    if (!kCountsBlocked) {
      [[unroll]] for (uint k = 1u; k < kMostRowsAtOnce; ++k) {
        if (found.starts[k] <= base) from = found.starts[k];
        if (found.starts[kMostRowsAtOnce - k] >= base + lanes) to = found.starts[kMostRowsAtOnce - k];
      }
    }
    // For the low and the high end of this lane's span: how many spans begin, and how many end, before it.
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

// Removes every end whose position an earlier entry of `ends` has. Returns how many ends are left.
//   In: end_count: number of entries before
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

// Fills `spans`, `window` and `ends`, the last without ends of equal positions. Returns FoundSpans::count and ups, the
// number of ends, and FoundSpans::held_rows. With more than kMostSpans spans only the first two are of use.
uvec4 sliceRows(Tile tile, uint lane, inout bool cut) {
  FoundSpans found = findSpans(tile, lane, cut);
  if (found.count > kMostSpans || found.count == 0u) return uvec4(found.count, found.ups, 0u, 0u);
  orderEnds(found, lane);
  return uvec4(found.count, found.ups, keepPositions(2u * found.count, lane, cut), found.held_rows);
}

// Takes the spans of `window` from `begin` to `end`. Moves the spans that reach beyond `position` to the end of this
// range.
// Returns where they begin; the others are lost.
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
