// Part of peel.glsl: with scanlines, the samples of a row.

// A polygon's part in the row, in columns from the tile's first in units of 2^-column_bits: first | last - first << 16.
uint spanOf(Tile tile, SnappedCorners corners) {
  int width = int(kTileWidth) << kColumnBits;
  int low = 0, high = width;
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    Edge edge = makeEdge(corners, k, kCutBits);
    int64_t value = int64_t(edge.a) * int64_t(tile.corner.x << kColumnBits) + (int64_t(edge.b) * int64_t(tile.corner.y) << kColumnBits) + edge.c;
    cutRow(edge, value, width, low, high);
  }
  return low < high ? uint(low) | uint(high - low - 1) << 16 : kNoColumns;
}

// Where span k of the row is: the first `ups` from the beginning, the others from the end.
uint placeOfSpan(uint k, uint ups) { return kCountsBlocked && k >= ups ? kMostSpans - 1u - (k - ups) : k; }

// Puts the row's spans and their ends, each once and in order, into shared memory. Where blocked pairs are counted the spans of polygons whose fronts face +u
// come first; of two-sided polygons all do.
// Returns the number of spans, of those that come first, and of ends; more than kMostSpans spans: nothing but their number.
uvec3 sliceRow(Tile tile, uint lane) {
  const uint lanes = gl_WorkGroupSize.x;
  uint ups = 0u, downs = 0u;
  for (uint base = 0u; base < tile.list_length; base += lanes) {
    uint mine = base + lane;
    uint polygon = texelFetch(list_texels, int(tile.list_start + min(mine, tile.list_length - 1u))).x;
    uint projected = tile.direction * args.polygon_count + polygon, columns = spanOf(tile, fetchCorners(projected));
    bool covers = mine < tile.list_length && columns != kNoColumns;
    bool is_up = !kCountsBlocked || kTwoSided || frontUpOf(texelFetch(projected_texels, int(kProjectedTexels * projected + 1u)).z) != 0u;
    uint all, place = ups + sumSoFar(covers && is_up ? 1u : 0u, all) - 1u;
    ups += all;
    if (kCountsBlocked) {
      uint from_end = downs + sumSoFar(covers && !is_up ? 1u : 0u, all) - 1u;
      downs += all;
      place = is_up ? place : kMostSpans - 1u - from_end;
    }
    if (covers && place < kMostSpans) spans[place] = uvec2(polygon, columns);
  }
  uint span_count = ups + downs;
  memoryBarrierShared();
  subgroupBarrier();
  if (span_count > kMostSpans || span_count == 0u) return uvec3(span_count, ups, 0u);

  for (uint base = 0u; base < span_count; base += lanes) {
    uint mine = base + lane;
    uint columns = spans[placeOfSpan(min(mine, span_count - 1u), ups)].y;
    uint low = columns & 0xFFFFu, high = low + (columns >> 16) + 1u;
    uint low_rank = 0u, high_rank = 0u;  // ends that come before; of equal ones the earlier span's, and its left one, come first
    for (uint other_base = 0u; other_base < span_count; other_base += lanes) {
      uint other = other_base + lane;
      uint other_columns = spans[placeOfSpan(min(other, span_count - 1u), ups)].y;
      uint other_low = other < span_count ? other_columns & 0xFFFFu : kEndless;
      uint other_high = other < span_count ? other_low + (other_columns >> 16) + 1u : kEndless;
      [[unroll]] for (uint t = 0u; t < 8u; ++t)
        for (uint eight = 0u; eight < lanes; eight += 8u) {
          uint a = subgroupShuffle(other_low, eight + t), b = subgroupShuffle(other_high, eight + t);
          uint before = other_base + eight + t < mine ? 1u : 0u, not_after = other_base + eight + t <= mine ? 1u : 0u;
          low_rank += uint(a < low + before) + uint(b < low + before);
          high_rank += uint(a < high + not_after) + uint(b < high + before);
        }
    }
    if (mine < span_count) {
      ends[low_rank] = low;
      ends[high_rank] = high;
    }
  }
  memoryBarrierShared();
  subgroupBarrier();
  uint kept = 0u, last = kEndless;
  for (uint base = 0u; base < 2u * span_count; base += lanes) {
    uint at = base + lane;
    uint end = ends[min(at, 2u * span_count - 1u)];
    uint before = subgroupShuffle(end, max(lane, 1u) - 1u);
    before = lane == 0u ? last : before;
    last = subgroupShuffle(end, lanes - 1u);
    bool keep = at < 2u * span_count && end != before;
    uint all, place = kept + sumSoFar(keep ? 1u : 0u, all) - 1u;
    memoryBarrierShared();
    subgroupBarrier();
    if (keep) ends[place] = end;
    kept += all;
  }
  memoryBarrierShared();
  subgroupBarrier();
  return uvec3(span_count, ups, kept);
}
