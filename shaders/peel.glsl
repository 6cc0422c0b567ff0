// One workgroup, meant to be one subgroup, peels one tile, with scanlines some rows of it. Each invocation takes kSteps
// samples. It keeps in registers the kLayersKept nearest layers of each behind the layers of the round before. It adds
// the gaps between consecutive layers to the counters, and goes round again where more layers remain. A sample is a
// lattice point or, with scanlines, the interval between two ends of spans. The order of polygons does not change in an
// interval, and its length is its weight. The tile's polygons are loaded one by each invocation and passed on by
// shuffles.
//   In: active_tiles, lists, projected, corners, polygons, fragments
//   Out: counters, unfinished tiles and the layers that they reached
// The file is long because its steps share the registers of an invocation: parts of it have no meaning alone.
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"
#include "counters.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;
layout(constant_id = 2) const bool kScanlines = false;
layout(constant_id = 3) const bool kSparse = false;     // counters in a hash table
layout(constant_id = 4) const bool kAllCount = true;    // every polygon emits and receives
layout(constant_id = 5) const bool kAggregates = true;  // adds runs of equal contributions at once
layout(constant_id = 6) const bool kMeasuresWork = false;
layout(constant_id = 7) const int kSteps = 8;               // samples of an invocation: 1, 2, 4 or 8
layout(constant_id = 8) const bool kIdsAreIndices = false;  // of polygons
layout(constant_id = 9) const uint kTileWidth = 8u;         // lattice points
layout(constant_id = 10) const
    bool kSorted = false;  // lists are in the order of their polygons' nearest depths in the tile, not with scanlines
layout(constant_id = 11) const bool kTwoSided = false;
layout(constant_id = 12) const bool kCountsBlocked = false;
layout(constant_id = 13) const
    bool kFragments = false;  // lattice points also have layers of fragments, beside the tile's polygons
layout(constant_id = 14) const uint kTileRows = 8u;
layout(constant_id = 15) const int kColumnBits = 0;                // of an edge's column coordinate: with scanlines
layout(constant_id = 16) const int kCutBits = 0;                   // see makeEdge
layout(binding = 5) uniform usamplerBuffer fragment_texels;        // uint64_t
layout(binding = 6) uniform usamplerBuffer fragment_count_texels;  // uint
layout(push_constant, scalar) uniform Args { PeelArgs pushed; };
PeelArgs args;

const int kMostSteps = 8;
const uint64_t kNoLayer = ~0ul;  // a layer is key << 32 | polygon, see Layer, so that layers are ordered as numbers
const uint kBackMark = 0x80000000u;
// With scanlines, the rows of a tile lie side by side: a position in them is row * kRowWidth + column, in units of
// 2^-column_bits from the tile's first.
const uint kRowWidth = kTileWidth << kColumnBits;  // 2^15
const uint kPositionBits = 17u;
const uint kPositions = 1u << kPositionBits;
const uint kNoColumns = ~0u;      // a span that holds no sample
const int kEndless = 0x7FFFFFFF;  // beyond the key of any end

// With scanlines, these arrays hold the spans of the rows: polygon, and columns as in spanOf; their ends in order; and
// the spans in order of where they begin. A window of the last holds the spans that reach the present samples, and
// moves on with them.
shared uvec2 spans[kScanlines ? kMostSpans : 1];
shared uint ends[kScanlines ? 2 * kMostSpans : 1];
shared uint window[kScanlines ? kMostSpans : 1];

// The samples of an invocation while it goes through the tile's polygons.
uint64_t nearest[kMostSteps][kLayersKept];
uint64_t last[kMostSteps];  // the farthest layer of the rounds before
bool open[kMostSteps];      // whether the line may meet more layers
uint end_count;             // with scanlines
uint fresh;                 // samples, a bit each, whose layers have not been counted yet
uint64_t lost[kMostSteps];  // the nearest layer that found no room
uint64_t farthest_emitter[kMostSteps], farthest_receiver[kMostSteps];
uint block;  // whose counters the tile adds to

// Where the invocation's first sample is; with lattice points the others follow rowsPerStep() apart.
struct Place {
  int column, row;  // of the tile: lattice columns, with scanlines units of 2^-column_bits; rows
  uint position;    // with scanlines: its middle
  uint weight;
};
Place sample_at;

// A Tally is the work done, of the subgroup or, from `samples` on, of the invocation.
struct Tally {
  uint rounds, tested;  // tested: polygons, of every round
  uint samples, fragments, gaps;
};
Tally tally;

int rowsPerStep() { return kScanlines ? 1 : int(gl_WorkGroupSize.x / kTileWidth); }

// Names every sample of an invocation by a literal number, so that all indices become constants.
#define EVERY_STEP(take)   \
  take(0);                 \
  if (kSteps > 1) take(1); \
  if (kSteps > 2) {        \
    take(2);               \
    take(3);               \
  }                        \
  if (kSteps > 4) {        \
    take(4);               \
    take(5);               \
    take(6);               \
    take(7);               \
  }

// A Passing is one polygon on its way past the samples.
struct Passing {
  ivec4 edges, edges_per_step;  // without scanlines
  bool covered;                 // with scanlines
  int64_t z, z_per_step;
  int z_shift, z_min, z_max;
  uint64_t rest;  // of the layer: the polygon, its facing, its place at ties
  uint roles;
};

struct Tile {
  uint list_start, list_length, direction, weight;
  ivec2 corner;  // of the lattice: the least column and row
  uint rows;     // with scanlines
  uint first_point, most_fragments;
  bool is_sorted;  // its list
};

// Return the ends of a span: see spanOf.
uint firstOf(uint columns) { return columns & kPositions - 1u; }
uint endOf(uint columns) { return firstOf(columns) + (columns >> kPositionBits) + 1u; }

#include "subgroup.glsl"
#include "slice.glsl"
#include "gaps.glsl"

// Adds up all meetings in the rows, of the spans that may be the nearer, the first `ups`, from the one `from` on, as
// far as one invocation may go. Returns how far it got. With scanlines peel_blocked.comp does it; peel.comp has nothing
// to do.
uint meetSpans(Tile tile, uint from, uint ups, uint span_count, inout uint blocks_done, inout bool cut);

// A layer of sample s, or kNoLayer, goes among the nearest; the farthest of those goes when there is no room.
void keepLayer(int s, uint64_t layer) {
  layer = layer > last[s] ? layer : kNoLayer;
  [[unroll]] for (int k = 0; k < kLayersKept; ++k) {
    uint64_t farther = max(nearest[s][k], layer);
    nearest[s][k] = min(nearest[s][k], layer);
    layer = farther;
  }
  lost[s] = min(lost[s], layer);
}

// Keeps fragment k of sample s, at the lattice point `point`, where it has more than k of them.
void keepFragment(int s, uint k, uint point, uint count) {
  bool has = k < count;
  uint64_t layer = packUint2x32(texelFetch(fragment_texels, int(k * args.point_count + point)).xy);
  if (kMeasuresWork) tally.fragments += has ? fresh >> s & 1u : 0u;
  keepLayer(s, has ? layer : kNoLayer);
}

// Takes sample s past the polygon.
void takeStep(int s, inout Passing polygon) {
  bool covered =
      kScanlines ? polygon.covered : (polygon.edges.x | polygon.edges.y | polygon.edges.z | polygon.edges.w) >= 0;
  uint64_t depth = uint64_t(clamp(polygon.z >> polygon.z_shift, int64_t(polygon.z_min), int64_t(polygon.z_max)));
  uint64_t layer = (depth << 32 + kTieBits) + polygon.rest;
  if (!kAllCount) {
    if (covered && (polygon.roles & kEmits) != 0u) farthest_emitter[s] = max(farthest_emitter[s], layer);
    if (covered && (polygon.roles & kReceives) != 0u) farthest_receiver[s] = max(farthest_receiver[s], layer);
  }
  if (kMeasuresWork) tally.fragments += covered ? fresh >> s & 1u : 0u;
  keepLayer(s, covered ? layer : kNoLayer);
  polygon.edges += polygon.edges_per_step;
  polygon.z += polygon.z_per_step;
}

// Leaves the rest of a tile to another dispatch. Returns where the layers go that its lines have reached.
uint leaveTile(uint place, uint first_sample, uint first_meeting, uint lane) {
  uint index = 0u;
  if (lane == 0u) {
    index = atomicAdd(Status(args.status).at.unfinished, 1u);
    UnfinishedTile rest;
    rest.tile = place;
    rest.first_sample = first_sample;
    rest.first_meeting = first_meeting;
    UnfinishedTiles(args.unfinished).at[index] = rest;
  }
  return (subgroupShuffle(index, 0u) * gl_WorkGroupSize.x + lane) * uint(kSteps);
}

// Leaves the samples from `first` on, of which the first have reached some layers, to another dispatch.
void leaveForLater(uint place, uint first, uint first_meeting, uint lane) {
  uint reached_at = leaveTile(place, first, first_meeting, lane);
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    if (k < kSteps) Longs(args.reached_next).at[reached_at + uint(k)] = open[k] ? last[k] : kNoLayer;
    open[k] = false;
  }
}

// Finds the workgroup's tile, and where it begins in it: its first sample and first meeting, and 1 + the place of the
// layers reached before, or 0. False where there is no tile.
bool findTile(uint lanes, out uint place, out uint first, out uint first_meeting, out uint resume) {
  uint group = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  bool found;
  place = group;
  first = first_meeting = resume = 0u;
  if (args.resumes == 0u) {
    uint active_tiles = Status(args.status).at.active_tiles;
    found = place < active_tiles && active_tiles < kListsOverflowed;
  } else {
    found = group < args.resumes;
    if (found) {
      UnfinishedTile rest = UnfinishedTiles(args.tiles).at[group];
      resume = group * lanes * uint(kSteps) + 1u;
      place = rest.tile;
      first = rest.first_sample;
      first_meeting = rest.first_meeting;
    }
  }
  return found;
}

Tile fetchTile(uint place) {
  uvec4 texel = texelFetch(tile_texels, int(kTileTexels * place)),
        corner = texelFetch(tile_texels, int(kTileTexels * place + 1u));
  uvec2 fragments_at = kFragments ? texelFetch(tile_texels, int(kTileTexels * place + 2u)).xy : uvec2(0);
  block = corner.w;
  return Tile(texel.x, texel.y, texel.z, texel.w, ivec2(corner.xy),
              kScanlines ? rowsAtOnce(texel.y, kTileRows) : kTileRows, fragments_at.x, fragments_at.y,
              kSorted && corner.z != 0u);
}

// The samples from `first` on, one a lane and step. With scanlines, `window` from list_begin to list_end moves on to
// the spans that reach them.
void loadSamples(Tile tile, uint first, uint sample_count, uint resume, uint lane, inout uint list_begin,
                 inout uint list_end, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    open[k] = k < kSteps && first + lane < sample_count && sample_at.row + k * rowsPerStep() < int(kTileRows);
    last[k] = resume == 0u || k >= kSteps ? 0ul : Longs(args.reached).at[resume - 1u + lane * uint(kSteps) + uint(k)];
    open[k] = open[k] && last[k] != kNoLayer;
    fresh = (k == 0 ? 0u : fresh) | (open[k] && last[k] == 0ul ? 1u << k : 0u);
  }
  sample_at.weight = tile.weight;
  if (kScanlines) {
    uint at = min(first + lane, sample_count - 1u), begin = ends[at], end = ends[at + 1u];
    uint from = positionOf(begin), to = positionOf(end);
    sample_at.position = (from + to - 1u) >> 1;  // the middle: where polygons meet at an end, depths tie
    sample_at.column = int(sample_at.position % kRowWidth);
    sample_at.weight *= to - from;
    if (from / kRowWidth != (to - 1u) / kRowWidth) fresh = 0u;  // no sample: the gap between two rows
    list_begin = dropEnded(list_begin, list_end, positionOf(subgroupShuffle(begin, 0u)), lane, cut);
    list_end = begunBefore(subgroupShuffle(end, lanes - 1u));
  }
}

void clearLayers() {
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    [[unroll]] for (int m = 0; m < kLayersKept; ++m) nearest[k][m] = kNoLayer;
    lost[k] = kNoLayer;
    farthest_emitter[k] = farthest_receiver[k] = 0ul;
  }
}

// Takes the samples past the fragments at their lattice points.
void takeFragments(Tile tile, inout bool cut) {
  const uint step = uint(rowsPerStep()) * kTileWidth;
  uint point = tile.first_point + (sample_at.row < int(kTileRows) ? uint(sample_at.row) * kTileWidth : 0u) +
               uint(sample_at.column),
       k = 0u;
  uint counts[kMostSteps];
  [[unroll]] for (uint s = 0u; s < uint(kMostSteps); ++s) counts[s] =
      int(s) < kSteps ? texelFetch(fragment_count_texels, int(point + s * step)).x : 0u;
  do {
#define TAKE(s) keepFragment(s, k, point + uint(s) * step, counts[s])
    EVERY_STEP(TAKE)
#undef TAKE
    ++k;
  } while (k < tile.most_fragments);
  cut = cut || k < tile.most_fragments;
}

// This invocation's entry of the list, to be passed on: its edges or its span, and its depth, at the tile's corner.
struct Loaded {
  ivec4 a, b, c;  // without scanlines: of its edges
  uint columns;   // with scanlines
  uvec4 plane;    // depth at the corner, whole depth per column
  uvec2 plane_y;  // per row
  uvec4 bounds;   // of its depth; its layer; bits of its depth per column
  uint roles;
};

Loaded loadPolygon(Tile tile, uint entry, uint list_end) {
  bool is_polygon = entry < list_end;
  uint mine = min(entry, max(list_end, 1u) - 1u);
  uvec2 span = kScanlines ? spans[spanIn(window[mine])]
                          : uvec2(list_end == 0u ? 0u : texelFetch(list_texels, int(tile.list_start + mine)).x, 0u);
  uint projected = tile.direction * args.polygon_count + span.x, projected_at = kProjectedTexels * projected;
  uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u));
  uvec4 depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
  Loaded loaded;
  loaded.columns = is_polygon ? span.y : kNoColumns;
  int span_row = kScanlines ? int(firstOf(loaded.columns) / kRowWidth) : 0;
  loaded.a = loaded.b = ivec4(0);
  loaded.c = ivec4(-1);  // covers nothing
  if (!kScanlines) {
    SnappedCorners corners = fetchCorners(projected);
    [[unroll]] for (uint k = 0u; k < 4u; ++k) {
      Edge edge = makeEdge(corners, k, kCutBits);
      loaded.a[k] = is_polygon ? edge.a : 0;
      loaded.b[k] = is_polygon ? edge.b : 0;
      loaded.c[k] = is_polygon ? valueAtCorner(edge, tile.corner) : -1;
    }
  }
  int64_t z_x = depthXOf(longFrom(depth_01.zw)), depth = longFrom(depth_01.xy) + z_x * int64_t(tile.corner.x) +
                                                         longFrom(depth_2.xy) * int64_t(tile.corner.y + span_row);
  // With scanlines: depth per spacing x column / 2^column_bits, rounded down; the product itself may need more than 64
  // bits.
  int64_t whole = kScanlines ? z_x >> kColumnBits : z_x;
  uint part = kScanlines ? uint(z_x - (whole << kColumnBits)) : 0u;
  loaded.plane = uvec4(unpackUint2x32(uint64_t(depth)), unpackUint2x32(uint64_t(whole)));
  loaded.plane_y = depth_2.xy;
  loaded.bounds = uvec4(depth_2.zw, packLayerPolygon(span.x, frontUpOf(depth_01.z)), part << 6 | depth_01.z & 63u);
  loaded.roles = kAllCount ? 0u : fetchId(span.x) >> kRolesShift;
  return loaded;
}

// Takes the samples past the polygon that lane t has loaded.
void takePolygon(Loaded loaded, uint t) {
  uvec4 p = subgroupShuffle(loaded.plane, t), d = subgroupShuffle(loaded.bounds, t);
  Passing polygon;
  polygon.z_shift = int(d.w >> 1 & 31u);
  polygon.z_min = int(d.x);
  polygon.z_max = depthMaxOf(d.y);
  polygon.rest = uint64_t(d.z) + (uint64_t(placeAtTieOf(d.y)) << 32);
  polygon.roles = kAllCount ? 0u : subgroupShuffle(loaded.roles, t);
  int64_t z_at_column = longFrom(p.xy) + longFrom(p.zw) * int64_t(sample_at.column);
  if (kScanlines) {
    uint in_span = subgroupShuffle(loaded.columns, t);
    polygon.covered = sample_at.position - firstOf(in_span) <= in_span >> kPositionBits && in_span != kNoColumns;
    polygon.z = z_at_column + int64_t((d.w >> 6) * uint(sample_at.column) >> kColumnBits);
  } else {
    ivec4 per_row = subgroupShuffle(loaded.b, t);
    polygon.edges =
        subgroupShuffle(loaded.a, t) * sample_at.column + per_row * sample_at.row + subgroupShuffle(loaded.c, t);
    polygon.edges_per_step = per_row * rowsPerStep();
    int64_t z_per_row = longFrom(subgroupShuffle(loaded.plane_y, t));
    polygon.z = z_at_column + z_per_row * int64_t(sample_at.row);
    polygon.z_per_step = z_per_row * int64_t(rowsPerStep());
  }
#define TAKE(s) takeStep(s, polygon)
  EVERY_STEP(TAKE)
#undef TAKE
}

// Returns whether a sample of the invocation keeps as many layers as it can.
bool isFull() {
  bool full = false;
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) full =
      full || (k < kSteps && open[k] && nearest[k][kLayersKept - 1] != kNoLayer);
  return full;
}

// Returns the key before which layers are settled once the list's entries before `next` have been taken. With sorted
// lists nothing from there on is nearer than the nearest depth of polygon `next` in the tile.
uint64_t settledBefore(Tile tile, uint next, uint list_end) {
  uint64_t bound = kNoLayer;
  if (kSorted) {
    uint polygon = texelFetch(list_texels, int(tile.list_start + min(next, max(list_end, 1u) - 1u))).x;
    DepthPlane plane = fetchDepthPlane(tile.direction * args.polygon_count + polygon, tile.corner);
    uint nearest_depth = nearestDepth(plane.at_corner, plane.per_column, plane.per_row, plane.shift, plane.range,
                                      ivec2(kTileWidth, kTileRows));
    if (next < list_end) bound = uint64_t(nearest_depth << kTieBits) << 32;
  }
  return bound;
}

// Takes the samples past the polygons from list_begin to list_end and adds the gaps of their layers. A segment ends
// where a sample has no room left or the list ends; its layers are added as far as they are settled.
void takePolygons(Tile tile, uint list_begin, uint list_end, uint lane, inout uint blocks_done, inout bool cut) {
  const uint lanes = gl_WorkGroupSize.x;
  uint base = list_begin, t = 0u, passed = 0u, patience = 0u;
  do {
    bool full = false;
    do {
      Loaded loaded = loadPolygon(tile, base + lane, list_end);
      do {
        takePolygon(loaded, t);
        ++t;
        ++passed;
        if (kSorted) full = anyOf(isFull() && tile.is_sorted && passed >= patience);
      } while (t < lanes && base + t < list_end && !full);
      cut = cut || (t < lanes && base + t < list_end && !full);
      bool block_ends = t >= lanes || base + t >= list_end;
      base += block_ends ? lanes : 0u;
      t = block_ends ? 0u : t;
      ++blocks_done;
    } while (base < list_end && !full);
    cut = cut || (base < list_end && !full);
    tally.gaps += flush(settledBefore(tile, base + t, list_end), base >= list_end, sample_at.weight, lane, cut);
    // Where nothing could be let go of, the next polygons are better left to another round than to a segment each.
    if (kSorted) patience = anyOf(isFull()) ? list_end : 0u;
  } while (base < list_end);
  cut = cut || base < list_end;
  tally.tested += kScanlines ? passed : list_end;
}

// Closes the samples that have all their layers, or that have no polygon behind them that counts. Returns whether the
// subgroup has any left.
bool closeSamples() {
  bool again = false;
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) {
    open[k] = open[k] && lost[k] != kNoLayer;
    if (!kAllCount)
      open[k] = open[k] && last[k] <= (args.counts_environment != 0u ? farthest_emitter[k]
                                                                     : min(farthest_emitter[k], farthest_receiver[k]));
    again = again || open[k];
  }
  return anyOf(again);
}

// In: begins: whether the tile's rows have not been counted by another dispatch
void addTally(uint row_count, uint polygon_count, bool begins, uint lane) {
  if (lane == 0u) atomicAdd(Status(args.status).at.rounds, tally.rounds);
  if (kMeasuresWork) {
    Status status = Status(args.status);
    uint all_fragments, all_gaps, all_samples;
    sumSoFar(tally.fragments, all_fragments);
    sumSoFar(tally.gaps, all_gaps);
    sumSoFar(tally.samples, all_samples);
    if (lane == 0u) {
      atomicAdd(status.at.rows, begins ? uint64_t(row_count) : 0ul);
      atomicAdd(status.at.spans, begins ? uint64_t(polygon_count) : 0ul);
      atomicAdd(status.at.samples, uint64_t(all_samples));
      atomicAdd(status.at.tests, uint64_t(tally.tested) * uint64_t(gl_WorkGroupSize.x * uint(kSteps)));
      atomicAdd(status.at.fragments, uint64_t(all_fragments));
      atomicAdd(status.at.gaps, uint64_t(all_gaps));
    }
  }
}

void main() {
  args = pushed;
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID, place, first, first_meeting, resume;
  if (gl_NumSubgroups != 1u) {
    atomicOr(Status(args.status).at.overflows, kOtherSubgroups);
    return;
  }
  if (!findTile(lanes, place, first, first_meeting, resume)) return;
  Tile tile = fetchTile(place);
  bool cut = false;  // whether a loop ended before its time
  uint sample_count = lanes, polygon_count = tile.list_length, rows = kTileRows, blocks_done = 0u;
  tally = Tally(0u, 0u, 0u, 0u, 0u);
  sample_at = Place(kScanlines ? 0 : int(lane % kTileWidth), kScanlines ? 0 : int(lane / kTileWidth), 0u, 0u);
  if (kScanlines) {
    uvec4 counts = sliceRows(tile, lane, cut);
    uint ups = counts.y;
    polygon_count = counts.x;
    end_count = counts.z;
    rows = counts.w;
    sample_count = max(end_count, 1u) - 1u;
    if (polygon_count > kMostSpans) {
      atomicOr(Status(args.status).at.overflows, kTooManySpans);
      return;
    }
    if (kCountsBlocked) {
      first_meeting = meetSpans(tile, first_meeting, ups, polygon_count, blocks_done, cut);
      if (first_meeting < ups) {
        Longs(args.reached_next).at[leaveTile(place, 0u, first_meeting, lane)] = 0ul;
        first = sample_count;
      }
    }
  }
  uint list_begin = 0u,
       list_end =
           kScanlines ? 0u : polygon_count;  // the samples pass so many: of the list or, with scanlines, of `window`
  while (first < sample_count && !cut) {
    loadSamples(tile, first, sample_count, resume, lane, list_begin, list_end, cut);
    resume = 0u;
    bool again;
    do {
      if (blocks_done >= args.most_blocks) {
        leaveForLater(place, first, first_meeting, lane);
        first = sample_count;
        again = false;
        break;
      }
      clearLayers();
      if (kFragments) {
        takeFragments(tile, cut);
        blocks_done += tile.most_fragments / lanes;
      }
      takePolygons(tile, list_begin, list_end, lane, blocks_done, cut);
      if (kMeasuresWork) tally.samples += bitCount(fresh);
      fresh = 0u;
      ++tally.rounds;
      again = closeSamples();
    } while (again);
    cut = cut || again;
    first += lanes;
  }
  if (cut || first < sample_count) atomicOr(Status(args.status).at.overflows, kLoopCut);
  addTally(rows, polygon_count, args.resumes == 0u && polygon_count > 0u, lane);
}
