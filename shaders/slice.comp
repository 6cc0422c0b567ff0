#version 460
// One workgroup, meant to be one subgroup, cuts the polygons of one tile into spans along the tile's rows, each invocation a polygon at a time, and
// enters every row that has any span. With scanlines it also puts the ends of a row's spans in order: between two of them the
// order of polygons does not change, so that every such interval is one sample with its length as weight.
//   In: active_tiles, lists, edges     Out: spans, samples, rows, status
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const uint kTileRows = 8u;
layout(constant_id = 2) const bool kScanlines = false;
layout(push_constant, scalar) uniform Args { SliceArgs args; };
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer SpansHere { Span at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer SamplesHere { uint at[]; };

// The least X in [0, width] with |a| X + value >= 0 (width where there is none).
// The quotient is off by less than one: tried and mended in integers.
int firstColumn(int size, int64_t value, double reciprocal, int width) {
  int x = int(clamp(ceil(-double(value) * reciprocal), 0.0LF, double(width)));
  int64_t at = int64_t(size) * int64_t(x) + value;
  if (at < int64_t(0)) return min(x + 1, width);
  return x > 0 && at - int64_t(size) >= int64_t(0) ? x - 1 : x;
}

// The part [low, high) of a row of columns on an edge's inner side; value: the edge at the row's first column.
void cutRow(Edge edge, int64_t value, double reciprocal, int width, inout int low, inout int high) {
  if (edge.a > 0) low = max(low, firstColumn(edge.a, value, reciprocal, width));
  else if (edge.a < 0) high = min(high, firstColumn(-edge.a, ~value, reciprocal, width));  // the first X outside: |a| X - value - 1 >= 0
  else if (value < int64_t(0)) high = 0;
}

uint sumBefore(uint value, uint lane, out uint total) {
  uint sum = value;
  [[unroll]] for (uint step = 1u; step < gl_WorkGroupSize.x; step *= 2u) {
    uint other = subgroupShuffle(sum, max(lane, step) - step);
    sum += lane >= step ? other : 0u;
  }
  total = subgroupShuffle(sum, gl_WorkGroupSize.x - 1u);
  return sum - value;
}

// Ends of the row's spans in order, each once; returns how many.
uint orderEnds(uint span_start, uint span_count, uint lane) {
  const uint lanes = gl_WorkGroupSize.x;
  SpansHere spans = SpansHere(args.spans);
  SamplesHere samples = SamplesHere(args.samples);
  uint compared = 0u;
  for (uint base = 0u; base < span_count; base += lanes) {
    uint mine = base + lane;
    uint columns = spans.at[span_start + min(mine, span_count - 1u)].columns;
    uint low = columns & 0xFFFFu, high = low + (columns >> 16) + 1u;
    uint low_rank = 0u, high_rank = 0u;
    for (uint other_base = 0u; other_base < span_count; other_base += lanes) {
      ++compared;
      uint other = other_base + lane;
      uint other_columns = spans.at[span_start + min(other, span_count - 1u)].columns;
      uint other_low = other < span_count ? other_columns & 0xFFFFu : 0xFFFFFFu, other_high = other < span_count ? (other_columns & 0xFFFFu) + (other_columns >> 16) + 1u : 0xFFFFFFu;
      [[unroll]] for (uint t = 0u; t < lanes; ++t) {
        uint a = subgroupShuffle(other_low, t), b = subgroupShuffle(other_high, t);
        uint before = other_base + t < mine ? 1u : 0u, not_after = other_base + t <= mine ? 1u : 0u;
        // Of equal ends the lower span's come first, and of one span the left one.
        low_rank += uint(a < low + before) + uint(b < low + before);
        high_rank += uint(a < high + not_after) + uint(b < high + before);
      }
    }
    if (mine < span_count) {
      samples.at[2u * span_start + low_rank] = low;
      samples.at[2u * span_start + high_rank] = high;
    }
  }
  memoryBarrierBuffer();
  subgroupBarrier();
  uint blocks = (span_count + lanes - 1u) / lanes;
  uint kept = 0u, last = 0xFFFFFFFFu, visited = 0u;
  for (uint base = 0u; base < 2u * span_count; base += lanes) {
    uint at = base + lane;
    uint end = samples.at[2u * span_start + min(at, 2u * span_count - 1u)];
    uint before = subgroupShuffle(end, max(lane, 1u) - 1u);
    before = lane == 0u ? last : before;
    last = subgroupShuffle(end, lanes - 1u);
    bool keep = at < 2u * span_count && end != before;
    uint total, place = kept + sumBefore(keep ? 1u : 0u, lane, total);
    memoryBarrierBuffer();
    subgroupBarrier();
    if (keep) samples.at[2u * span_start + place] = end;
    kept += total;
    visited += lanes;
  }
  if (compared < blocks * blocks || visited < 2u * span_count) atomicOr(Status(args.status).at.overflows, kTileCut);
  memoryBarrierBuffer();
  subgroupBarrier();
  return kept;
}

void main() {
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  Status status = Status(args.status);
  if (status.at.overflows == kListsOverflowed || place >= status.at.active_tiles) return;
  uvec4 list = texelFetch(tile_texels, int(2u * place));  // start, length, direction, column
  int tile_row = int(texelFetch(tile_texels, int(2u * place + 1u)).x);
  int tile_column = int(list.w) << args.column_bits;
  int width = int(args.tile_width) << args.column_bits;
  uint lane = gl_SubgroupInvocationID;
  Spans spans = Spans(args.spans);

  uint counts[kMostRowsPerTile];
  for (uint r = 0u; r < kMostRowsPerTile; ++r) counts[r] = 0u;
  uint scanned = 0u;
  for (uint base = 0u; base < list.y; base += gl_WorkGroupSize.x) {
    uint mine = base + lane;
    uint polygon = texelFetch(list_texels, int(list.x + min(mine, list.y - 1u))).x;
    uvec2 corners = texelFetch(polygon_texels, int(3u * polygon)).xy;
    uint edge_at = list.z * args.corner_count + corners.x;
    int low[kMostRowsPerTile], high[kMostRowsPerTile];
    [[unroll]] for (uint r = 0u; r < kTileRows; ++r) {
      low[r] = 0;
      high[r] = mine < list.y ? width : 0;
    }
    uint k = 0u;
    do {
      [[unroll]] for (uint four = 0u; four < 4u; ++four) {
        Edge edge = fetchEdge(edge_at + min(k + four, corners.y - 1u));
        int64_t per_row = int64_t(edge.b) << args.column_bits;
        int64_t value = int64_t(edge.a) * int64_t(tile_column) + per_row * int64_t(tile_row) + edge.c;
        double reciprocal = 1.0LF / double(max(abs(edge.a), 1));
        [[unroll]] for (uint r = 0u; r < kTileRows; ++r) {
          cutRow(edge, value, reciprocal, width, low[r], high[r]);
          value += per_row;
        }
      }
      k += 4u;
    } while (k < corners.y);
    [[unroll]] for (uint r = 0u; r < kTileRows; ++r) {
      bool covers = low[r] < high[r];
      uint total, at = (list.x * kTileRows + r * list.y) + counts[r] + sumBefore(covers ? 1u : 0u, lane, total);
      if (covers) {
        Span span;
        span.polygon = polygon;
        span.columns = uint(low[r]) | uint(high[r] - low[r] - 1) << 16;
        spans.at[at] = span;
      }
      counts[r] += total;
    }
    scanned += gl_WorkGroupSize.x;
  }
  if (scanned < list.y) atomicOr(status.at.overflows, kTileCut);

  uint sample_counts[kMostRowsPerTile];
  if (kScanlines) {
    memoryBarrierBuffer();
    subgroupBarrier();
    for (uint r = 0u; r < kTileRows; ++r) {
      uint ends = orderEnds(list.x * kTileRows + r * list.y, counts[r], lane);
      sample_counts[r] = max(ends, 1u) - 1u;
    }
  }
  uint my_count = 0u, my_samples = args.tile_width;
  [[unroll]] for (uint r = 0u; r < kTileRows; ++r) {
    if (lane != r) continue;
    my_count = counts[r];
    if (kScanlines) my_samples = sample_counts[r];
  }
  if (my_count == 0u) return;
  uint row_place = atomicAdd(status.at.rows, 1u);
  atomicMax(status.at.peel_groups.x, min(row_place + 1u, kGroupsPerRow));
  atomicMax(status.at.peel_groups.y, row_place / kGroupsPerRow + 1u);
  Row row;
  row.span_start = list.x * kTileRows + lane * list.y;
  row.span_count = my_count;
  row.sample_count = my_samples;
  row.direction = list.z;
  row.column = int(list.w);
  row.row = tile_row + int(lane);
  row.first_sample = 0u;
  row.resume = 0u;
  Rows(args.rows).at[row_place] = row;
}
