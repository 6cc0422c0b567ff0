// This part of peel_blocked.comp counts, with scanlines, on which lengths of the rows two polygons face each other,
// whatever lies between the two. Party::samples is a span here: its first position and the position after its last.

// Returns the depth of a polygon at a position in the rows.
uint depthInRow(DepthPlane plane, uint position) {
  int column = int(position % kRowWidth), row = int(position / kRowWidth);
  // Over the columns the depth grows by per_column x column / 2^kColumnBits, rounded down. This product may need more
  // than 64 bits, so per_column is divided first, with remainder.
  int64_t whole = plane.per_column >> kColumnBits, rest = plane.per_column - (whole << kColumnBits);
  int64_t depth = plane.at_corner + plane.per_row * int64_t(row) + whole * int64_t(column) +
                  (rest * int64_t(column) >> kColumnBits);
  return uint(clamp(depth >> plane.shift, int64_t(plane.range.x), int64_t(plane.range.y)));
}

Party fetchParty(uint place, uint direction, ivec2 corner) {
  uvec2 span = spans[place];
  DepthPlane plane = fetchDepthPlane(direction * args.polygon_count + span.x, corner);
  Party party;
  party.polygon = span.x;
  party.samples = uvec2(firstOf(span.y), endOf(span.y));
  uint depth_first = depthInRow(plane, party.samples.x), depth_last = depthInRow(plane, party.samples.y - 1u);
  party.nearest = min(depth_first, depth_last) << kTieBits | plane.place_at_tie;
  party.farthest = max(depth_first, depth_last) << kTieBits | plane.place_at_tie;
  return party;
}

bool haveCommon(uvec2 samples, uvec2 others) { return max(samples.x, others.x) < min(samples.y, others.y); }

uint countCommon(uvec2 samples, uvec2 others) { return min(samples.y, others.y) - max(samples.x, others.x); }

// Compares depths in the middle of every interval between two ends of spans. Peel orders its layers by the depths
// there, too.
uint countInOrder(uvec2 samples, uvec2 others, DepthPlane nearer, DepthPlane farther, inout bool cut) {
  uint from = max(samples.x, others.x), to = min(samples.y, others.y), at = 0u, count = 0u;
  [[unroll]] for (uint step = kMostSpans; step > 0u;
                  step /= 2u) if (at + step < end_count && positionOf(ends[at + step]) <= from) at += step;
  while (from < to) {
    uint end = min(positionOf(ends[min(at + 1u, end_count - 1u)]), to);
    uint middle = (from + end - 1u) >> 1;
    count += isBefore(nearer, depthInRow(nearer, middle), farther, depthInRow(farther, middle)) ? end - from : 0u;
    from = end;
    ++at;
  }
  cut = cut || from < to;
  return count;
}

// Counts on which parts of the rows two polygons face each other, whatever lies between them. Its declaration in
// peel.glsl describes the arguments and the result.
uint meetSpans(Tile tile, uint from, uint ups, uint span_count, inout uint blocks_done, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  Parties parties;
  parties.farther = kTwoSided ? 0u : kMostSpans - (span_count - ups);
  parties.farther_end = kTwoSided ? ups : kMostSpans;
  parties.direction = tile.direction;
  parties.weight = tile.weight;
  parties.corner = tile.corner;
  if (parties.farther == parties.farther_end) return ups;
  while (from < ups && blocks_done < args.most_blocks) {
    uint steps = 0u;
    parties.nearer = from;
    parties.nearer_end = min(from + lanes, ups);
    addMeeting(parties, peelCounters(), false, steps, cut);
    if (!kTwoSided) addMeeting(parties, peelCounters(), true, steps, cut);
    blocks_done += (steps + lanes - 1u) / lanes;
    from += lanes;
  }
  return from;
}
