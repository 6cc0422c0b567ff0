#version 460
// One workgroup, meant to be one subgroup, peels one tile, or with scanlines one row of it: each invocation takes kSteps samples and keeps the
// kLayersKept nearest layers of each behind those of the round before in registers; it adds what the gaps between consecutive
// layers contribute to the counters, and goes round again where more layers remain. A sample is a lattice point or, with
// scanlines, the interval between two ends of spans: the order of polygons does not change in it, and its length is its weight. The
// tile's polygons are loaded one by each invocation and passed on by shuffles.
//   In: active_tiles, lists, projected, edges, polygons     Out: counters, unfinished tiles or rows and the layers that they reached
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"
#include "geometry.glsl"
#include "counters.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;
layout(constant_id = 2) const bool kScanlines = false;
layout(constant_id = 3) const bool kSparse = false;      // counters in a hash table
layout(constant_id = 4) const bool kAllCount = true;     // every polygon emits and receives
layout(constant_id = 5) const bool kAggregates = true;   // adds runs of equal contributions at once
layout(constant_id = 6) const bool kMeasuresWork = false;
layout(constant_id = 7) const int kSteps = 8;            // samples of an invocation: 1, 2, 4 or 8
layout(constant_id = 8) const bool kIdsAreIndices = false;  // of polygons
layout(constant_id = 9) const uint kTileWidth = 8u;        // lattice points
layout(constant_id = 10) const bool kSorted = false;       // lists are in the order of their polygons' nearest depths in the tile, not with scanlines
layout(push_constant, scalar) uniform Args { PeelArgs args; };

const int kMostSteps = 8;
const uint64_t kNoLayer = ~0ul;    // a layer is key << 32 | polygon + 1, so that layers are ordered as numbers
const int kSaturated = 1 << 30;    // beyond what an edge can change by within a tile
const uint kBackMark = 0x80000000u;
const uint kNoColumns = 0xFFFFu;   // a span that holds no sample
const uint kEndless = 0xFFFFFFu;   // beyond any column

// With scanlines, the spans of the row: polygon, and columns as in spanOf; and their ends in order.
shared uvec2 spans[kScanlines ? kMostSpans : 1];
shared uint ends[kScanlines ? 2 * kMostSpans : 1];

// The samples of an invocation while it goes through the tile's polygons.
uint64_t nearest[kMostSteps][kLayersKept];
uint64_t last[kMostSteps];  // the farthest layer of the rounds before
bool open[kMostSteps];      // whether the line may meet more layers
uint fresh;                 // samples, a bit each, whose layers have not been counted yet
uint64_t lost[kMostSteps];  // the nearest layer that found no room
uint64_t farthest_emitter[kMostSteps], farthest_receiver[kMostSteps];

// One polygon on its way past the samples.
struct Passing {
  ivec4 edges, edges_per_step;    // without scanlines
  bool covered;                   // with scanlines
  int64_t z, z_per_step;
  int z_shift, z_min, z_max;
  uint front_up, layer_polygon, roles;
};

struct Tile {
  uint list_start, list_length, direction, weight;
  ivec2 corner;  // of the lattice: the least column and row, or the one row, of what is peeled
};

// A polygon's part in the row, in columns from the tile's first in units of 2^-column_bits: first | last - first << 16.
uint spanOf(Tile tile, uint first_edge, uint edge_count) {
  int width = int(args.tile_width) << args.column_bits;
  int low = 0, high = width;
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    Edge edge = fetchEdge(first_edge + min(k, edge_count - 1u));
    int64_t value = int64_t(edge.a) * int64_t(tile.corner.x << args.column_bits) + (int64_t(edge.b) * int64_t(tile.corner.y) << args.column_bits) + edge.c;
    cutRow(edge, value, width, low, high);
  }
  return low < high ? uint(low) | uint(high - low - 1) << 16 : kNoColumns;
}

// Puts the row's spans and their ends, each once and in order, into shared memory.
// Returns the number of spans and of ends; more than kMostSpans spans: nothing but their number.
uvec2 sliceRow(Tile tile, uint lane) {
  const uint lanes = gl_WorkGroupSize.x;
  uint span_count = 0u;
  for (uint base = 0u; base < tile.list_length; base += lanes) {
    uint mine = base + lane;
    uint polygon = texelFetch(list_texels, int(tile.list_start + min(mine, tile.list_length - 1u))).x;
    uvec4 projected = texelFetch(projected_texels, int(4u * (tile.direction * args.polygon_count + polygon) + 3u));
    uint columns = spanOf(tile, projected.z, projected.w);
    bool covers = mine < tile.list_length && columns != kNoColumns;
    uint place = span_count + subgroupExclusiveAdd(covers ? 1u : 0u);
    if (covers && place < kMostSpans) spans[place] = uvec2(polygon, columns);
    span_count += subgroupAdd(covers ? 1u : 0u);
  }
  memoryBarrierShared();
  subgroupBarrier();
  if (span_count > kMostSpans || span_count == 0u) return uvec2(span_count, 0u);

  for (uint base = 0u; base < span_count; base += lanes) {
    uint mine = base + lane;
    uint columns = spans[min(mine, span_count - 1u)].y;
    uint low = columns & 0xFFFFu, high = low + (columns >> 16) + 1u;
    uint low_rank = 0u, high_rank = 0u;  // ends that come before; of equal ones the earlier span's, and its left one, come first
    for (uint other_base = 0u; other_base < span_count; other_base += lanes) {
      uint other = other_base + lane;
      uint other_columns = spans[min(other, span_count - 1u)].y;
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
    uint place = kept + subgroupExclusiveAdd(keep ? 1u : 0u);
    memoryBarrierShared();
    subgroupBarrier();
    if (keep) ends[place] = end;
    kept += subgroupAdd(keep ? 1u : 0u);
  }
  memoryBarrierShared();
  subgroupBarrier();
  return uvec2(span_count, kept);
}

// Whether a gap contributes to anything that was asked for; lower and upper: ids with roles.
bool isCounted(uint gap, uint lower, uint upper) {
  if (kAllCount) return gap != kGapNothing;
  uint lower_roles = lower >> kRolesShift, upper_roles = upper >> kRolesShift;
  if (gap == kGapFacingPair)
    return ((lower_roles & kEmits) != 0u && (upper_roles & kReceives) != 0u) || ((upper_roles & kEmits) != 0u && (lower_roles & kReceives) != 0u);
  if (gap == kGapNothing || args.counts_environment == 0u) return false;
  return ((gap == kGapLowerEnvironment || gap == kGapLowerLeak ? lower_roles : upper_roles) & kEmits) != 0u;
}

uint idOf(uint layer_polygon) {
  if (layer_polygon == 0u) return 0u;
  return kIdsAreIndices ? layer_polygon - 1u : fetchId(layer_polygon - 1u);
}

// Adds up what neighbouring lanes with the same pair have: the first of a run adds for all.
void addRuns(bool has, uvec2 pair, uint weight, uint lane) {
  if (kAggregates) {
    const uint lanes = gl_WorkGroupSize.x;
    uvec2 key = has ? pair : uvec2(~0u);
    uvec2 before = subgroupShuffle(key, max(lane, 1u) - 1u);
    bool head = lane == 0u || key != before;
    uint end = subgroupShuffle(head ? lane : lanes, min(lane + 1u, lanes - 1u));  // of the run: where the next one begins
    if (lane + 1u == lanes) end = lanes;
    uint sum = weight;
    [[unroll]] for (uint step = 1u; step < lanes; step *= 2u) {
      uint next_end = subgroupShuffle(end, min(lane + step, lanes - 1u));
      end = min(end, lane + step < lanes ? next_end : lanes);
      uint other = subgroupShuffle(sum, max(lane, step) - step);
      sum += lane >= step ? other : 0u;
    }
    uint to_end = subgroupShuffle(sum, end - 1u);
    has = has && head;
    weight = to_end - sum + weight;
  }
  if (has) addCount(args.counters, args.counter_mask, args.status, args.id_count, kSparse, pair, weight);
}

// Adds the gaps between consecutive layers of one sample a lane: below those nearer than `bound`, and at the end the one above the last of them. Moves
// `before` to the last of them. Returns the number of gaps counted.
// Gaps that count are gathered first: of the layers of closed solids only every other gap does.
uint addGaps(inout uint64_t before, uint64_t layers[kLayersKept], uint64_t bound, bool at_end, bool is_open, uint weight, uint lane, inout bool cut) {
  uvec2 found[kLayersKept + 1];  // lower and upper polygon, + 1; kBackMark where it does not turn a front to the gap
  uint count = 0u;
  [[unroll]] for (int k = 0; k <= kLayersKept; ++k) found[k] = uvec2(0);
  [[unroll]] for (int k = 0; k <= kLayersKept; ++k) {
    uint64_t upper = k < kLayersKept ? layers[k] : kNoLayer;
    is_open = is_open && (upper < bound || (at_end && bound == kNoLayer));
    bool lower_front = before != 0ul && (args.two_sided != 0u || (before >> 32 & 1ul) == 0ul);
    bool upper_front = upper != kNoLayer && (args.two_sided != 0u || (upper >> 32 & 1ul) != 0ul);
    uvec2 gap = uvec2(unpackUint2x32(before).x, upper == kNoLayer ? 0u : unpackUint2x32(upper).x);
    gap |= uvec2(lower_front ? 0u : kBackMark, upper_front ? 0u : kBackMark);
    bool counted = is_open && (lower_front || upper_front);
    [[unroll]] for (int m = 0; m <= k; ++m) found[m] = counted && count == uint(m) ? gap : found[m];
    count += counted ? 1u : 0u;
    is_open = is_open && upper != kNoLayer;
    before = is_open ? upper : before;
  }
  uint added = 0u, left = count;
  while (subgroupAny(left > 0u)) {
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

// Adds, step by step, the gaps of the layers nearer than `bound`, which nothing that is still to come can part, and makes room for others.
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
      [[unroll]] for (int k = 0; k < kLayersKept; ++k) {  // what has been added goes
        bool first_gone = layers[0] <= before && layers[0] < its_bound;
        [[unroll]] for (int m = 0; m < kLayersKept; ++m) layers[m] = first_gone ? m + 1 < kLayersKept ? layers[m + 1] : kNoLayer : layers[m];
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

// Takes sample s past the polygon: its layer goes among the nearest, the farthest of those goes when there is no room.
// Called with a literal s, so that all indices become constants.
void takeStep(int s, inout Passing polygon, inout uint fragments) {
  bool covered = kScanlines ? polygon.covered : (polygon.edges.x | polygon.edges.y | polygon.edges.z | polygon.edges.w) >= 0;
  uint depth = uint(clamp(polygon.z >> polygon.z_shift, int64_t(polygon.z_min), int64_t(polygon.z_max)));
  uint64_t layer = packUint2x32(uvec2(polygon.layer_polygon, 2u * depth + 1u - polygon.front_up));
  if (!kAllCount) {
    if (covered && (polygon.roles & kEmits) != 0u) farthest_emitter[s] = max(farthest_emitter[s], layer);
    if (covered && (polygon.roles & kReceives) != 0u) farthest_receiver[s] = max(farthest_receiver[s], layer);
  }
  if (kMeasuresWork) fragments += covered ? fresh >> s & 1u : 0u;
  layer = covered && layer > last[s] ? layer : kNoLayer;
  [[unroll]] for (int k = 0; k < kLayersKept; ++k) {
    uint64_t farther = max(nearest[s][k], layer);
    nearest[s][k] = min(nearest[s][k], layer);
    layer = farther;
  }
  lost[s] = min(lost[s], layer);
  polygon.edges += polygon.edges_per_step;
  polygon.z += polygon.z_per_step;
}

void main() {
  const uint lanes = gl_WorkGroupSize.x;
  const int rows_per_step = kScanlines ? 1 : int(lanes / kTileWidth);
  uint lane = gl_SubgroupInvocationID;
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  uint row = gl_WorkGroupID.z, first = 0u, resume = 0u;
  Status status = Status(args.status);
  if (gl_NumSubgroups != 1u) {
    atomicOr(status.at.overflows, kOtherSubgroups);
    return;
  }
  if (args.resumes != 0u) {
    if (place >= args.resumes) return;
    UnfinishedRow rest = UnfinishedRows(args.rows).at[place];
    resume = place * lanes * uint(kSteps) + 1u;
    place = rest.tile;
    row = rest.row;
    first = rest.first_sample;
  } else {
    uint active_tiles = status.at.active_tiles;
    if (place >= active_tiles || active_tiles >= kListsOverflowed) return;
  }
  uvec4 texel = texelFetch(tile_texels, int(2u * place));
  uvec2 corner = texelFetch(tile_texels, int(2u * place + 1u)).xy;
  bool is_sorted = kSorted && texelFetch(tile_texels, int(2u * place + 1u)).z != 0u;
  Tile tile = Tile(texel.x, texel.y, texel.z, texel.w, ivec2(corner) + ivec2(0, row));
  bool cut = false;  // whether a loop ended before its time
  uint sample_count = lanes, polygon_count = tile.list_length;
  // Lattice points: a lane's column, and the row of its first sample; the others follow rows_per_step apart.
  int column = kScanlines ? 0 : int(lane % kTileWidth), lane_row = kScanlines ? 0 : int(lane / kTileWidth);
  if (kScanlines) {
    uvec2 counts = sliceRow(tile, lane);
    polygon_count = counts.x;
    sample_count = max(counts.y, 1u) - 1u;
    if (counts.x > kMostSpans) {
      atomicOr(status.at.overflows, kTooManySpans);
      return;
    }
    cut = counts.x > 0u && counts.y < 2u;
  }

  uint blocks_done = 0u, rounds = 0u, fragments = 0u, gaps = 0u;
  while (first < sample_count && !cut) {
    uint weight = tile.weight;
    [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
      open[k] = k < kSteps && first + lane < sample_count && lane_row + k * rows_per_step < int(args.tile_rows);
      last[k] = resume == 0u || k >= kSteps ? 0ul : Longs(args.reached).at[resume - 1u + lane * uint(kSteps) + uint(k)];
      open[k] = open[k] && last[k] != kNoLayer;
      fresh = (k == 0 ? 0u : fresh) | (open[k] && last[k] == 0ul ? 1u << k : 0u);
    }
    resume = 0u;
    if (kScanlines) {
      uint at = min(first + lane, sample_count - 1u);
      int from = int(ends[at]), to = int(ends[at + 1u]);
      column = (from + to - 1) >> 1;  // the middle: where polygons meet at an end, depths tie
      weight *= uint(to - from);
    }
    bool again;
    do {
      if (blocks_done >= args.most_blocks) {  // the rest goes to another dispatch
        uint index = 0u;
        if (lane == 0u) {
          index = atomicAdd(status.at.unfinished, 1u);
          UnfinishedRow rest;
          rest.tile = place;
          rest.row = row;
          rest.first_sample = first;
          UnfinishedRows(args.unfinished).at[index] = rest;
        }
        index = subgroupShuffle(index, 0u);
        [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
          if (k < kSteps) Longs(args.reached_next).at[(index * lanes + lane) * uint(kSteps) + uint(k)] = open[k] ? last[k] : kNoLayer;
          open[k] = false;
        }
        first = sample_count;
        again = false;
        break;
      }
      [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
        [[unroll]] for (int m = 0; m < kLayersKept; ++m) nearest[k][m] = kNoLayer;
        lost[k] = kNoLayer;
        farthest_emitter[k] = farthest_receiver[k] = 0ul;
      }
      // A segment ends where a sample has no room left or the list ends; its layers are added as far as they are settled.
      uint base = 0u, t = 0u, passed = 0u, patience = 0u;
      do {
        bool full = false;
        do {
          // This invocation's polygon: its edges or its span, and its depth, at the corner.
          uint mine = min(base + lane, polygon_count - 1u);
          uvec2 span = kScanlines ? spans[mine] : uvec2(texelFetch(list_texels, int(tile.list_start + mine)).x, 0u);
          uint projected_at = 4u * (tile.direction * args.polygon_count + span.x);
          uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u));
          uvec4 depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
          uvec4 rest = texelFetch(projected_texels, int(projected_at + 3u));
          if (base + lane >= polygon_count) span.y = kNoColumns;
          ivec4 a = ivec4(0), b = ivec4(0), c = ivec4(base + lane < polygon_count ? 0 : -1);
          if (!kScanlines) {
            [[unroll]] for (uint k = 0u; k < 4u; ++k) {
              Edge edge = fetchEdge(rest.z + min(k, rest.w - 1u));
              a[k] = edge.a;
              b[k] = edge.b;
              int64_t at_corner = int64_t(edge.a) * int64_t(tile.corner.x) + int64_t(edge.b) * int64_t(tile.corner.y) + edge.c;
              if (c[k] >= 0) c[k] = int(clamp(at_corner, int64_t(-kSaturated), int64_t(kSaturated)));
            }
          }
          int64_t depth = longFrom(depth_01.xy) + longFrom(depth_01.zw) * int64_t(tile.corner.x) + longFrom(depth_2.xy) * int64_t(tile.corner.y);
          uvec4 plane = uvec4(unpackUint2x32(uint64_t(depth)), depth_01.zw);
          uvec2 plane_y = depth_2.xy;
          uvec4 bounds = uvec4(depth_2.zw, span.x + 1u, 2u * rest.x + rest.y);
          uint roles = kAllCount ? 0u : fetchId(span.x) >> kRolesShift;
          do {
            uvec4 p = subgroupShuffle(plane, t), d = subgroupShuffle(bounds, t);
            Passing polygon;
            polygon.z_shift = int(d.w >> 1);
            polygon.z_min = int(d.x);
            polygon.z_max = int(d.y);
            polygon.layer_polygon = d.z;
            polygon.front_up = d.w & 1u;
            polygon.roles = kAllCount ? 0u : subgroupShuffle(roles, t);
            if (kScanlines) {
              uint in_span = subgroupShuffle(span.y, t);
              polygon.covered = uint(column) - (in_span & 0xFFFFu) <= in_span >> 16 && in_span != kNoColumns;
              // z per spacing x column / 2^column_bits, rounded down; the product itself may need more than 64 bits.
              int64_t z_x = longFrom(p.zw), whole = z_x >> args.column_bits, rest_x = z_x - (whole << args.column_bits);
              polygon.z = longFrom(p.xy) + whole * int64_t(column) + (rest_x * int64_t(column) >> args.column_bits);
            } else {
              ivec4 per_row = subgroupShuffle(b, t);
              polygon.edges = subgroupShuffle(a, t) * column + per_row * lane_row + subgroupShuffle(c, t);
              polygon.edges_per_step = per_row * rows_per_step;
              int64_t z_per_row = longFrom(subgroupShuffle(plane_y, t));
              polygon.z = longFrom(p.xy) + longFrom(p.zw) * int64_t(column) + z_per_row * int64_t(lane_row);
              polygon.z_per_step = z_per_row * int64_t(rows_per_step);
            }
            takeStep(0, polygon, fragments);
            if (kSteps > 1) takeStep(1, polygon, fragments);
            if (kSteps > 2) takeStep(2, polygon, fragments);
            if (kSteps > 2) takeStep(3, polygon, fragments);
            if (kSteps > 4) takeStep(4, polygon, fragments);
            if (kSteps > 4) takeStep(5, polygon, fragments);
            if (kSteps > 4) takeStep(6, polygon, fragments);
            if (kSteps > 4) takeStep(7, polygon, fragments);
            ++t;
            ++passed;
            if (kSorted) {
              bool no_room = false;
              [[unroll]] for (int k = 0; k < kMostSteps; ++k) no_room = no_room || (k < kSteps && open[k] && nearest[k][kLayersKept - 1] != kNoLayer);
              full = subgroupAny(no_room && is_sorted && passed >= patience);
            }
          } while (t < lanes && base + t < polygon_count && !full);
          cut = cut || (t < lanes && base + t < polygon_count && !full);
          bool block_ends = t >= lanes || base + t >= polygon_count;
          base += block_ends ? lanes : 0u;
          t = block_ends ? 0u : t;
          ++blocks_done;
        } while (base < polygon_count && !full);
        cut = cut || (base < polygon_count && !full);
        uint64_t bound = kNoLayer;
        if (kSorted) {  // nothing from the next polygon on is nearer than its nearest depth in the tile
          uint next = texelFetch(list_texels, int(tile.list_start + min(base + t, polygon_count - 1u))).x;
          uint projected_at = 4u * (tile.direction * args.polygon_count + next);
          uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u)), depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
          int shift = int(texelFetch(projected_texels, int(projected_at + 3u)).x);
          int64_t depth = longFrom(depth_01.xy) + longFrom(depth_01.zw) * int64_t(tile.corner.x) + longFrom(depth_2.xy) * int64_t(tile.corner.y);
          uint nearest_depth = nearestDepth(depth, longFrom(depth_01.zw), longFrom(depth_2.xy), shift, ivec2(depth_2.zw), ivec2(kTileWidth, args.tile_rows));
          if (base < polygon_count) bound = uint64_t(2u * nearest_depth) << 32;
        }
        gaps += flush(bound, base >= polygon_count, weight, lane, cut);
        if (kSorted) {  // where nothing could be let go of, the next polygons are better left to another round than to a segment each
          bool stuck = false;
          [[unroll]] for (int k = 0; k < kMostSteps; ++k) stuck = stuck || (k < kSteps && open[k] && nearest[k][kLayersKept - 1] != kNoLayer);
          patience = subgroupAny(stuck) ? polygon_count : 0u;
        }
      } while (base < polygon_count);
      cut = cut || base < polygon_count;
      fresh = 0u;
      ++rounds;

      again = false;
      [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
        open[k] = open[k] && lost[k] != kNoLayer;
        if (!kAllCount) open[k] = open[k] && last[k] <= (args.counts_environment != 0u ? farthest_emitter[k] : min(farthest_emitter[k], farthest_receiver[k]));
        again = again || open[k];
      }
      again = subgroupAny(again);
    } while (again);
    cut = cut || again;
    first += lanes;
  }
  if (cut || first < sample_count) atomicOr(status.at.overflows, kLoopCut);
  if (lane == 0u) atomicAdd(status.at.rounds, rounds);
  if (kMeasuresWork) {
    uint all_fragments = subgroupAdd(fragments), all_gaps = subgroupAdd(gaps);
    bool begins = args.resumes == 0u && polygon_count > 0u;
    if (lane == 0u) {
      atomicAdd(status.at.rows, begins ? kScanlines ? 1ul : uint64_t(args.tile_rows) : 0ul);
      atomicAdd(status.at.spans, begins ? uint64_t(polygon_count) : 0ul);
      atomicAdd(status.at.samples, begins ? uint64_t(kScanlines ? sample_count : kTileWidth * args.tile_rows) : 0ul);
      atomicAdd(status.at.tests, uint64_t(rounds) * uint64_t(polygon_count) * uint64_t(lanes * uint(kSteps)));
      atomicAdd(status.at.fragments, uint64_t(all_fragments));
      atomicAdd(status.at.gaps, uint64_t(all_gaps));
    }
  }
}
