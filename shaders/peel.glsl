// One workgroup, which has to be one subgroup, peels one active tile. A sample is a lattice point or, with scanlines,
// the interval between two neighbouring ends of spans, whose length is its weight. (A span is the part of a row that a
// polygon covers.) The order of the polygons is constant in an interval. Each invocation has kSteps samples. It goes
// through the tile's polygons in rounds. In a round it keeps in registers, for each sample, the kLayersKept nearest
// layers behind the layers of the round before. Then it adds the gaps between consecutive layers to the counters.
// Rounds end when no sample has further layers. Each invocation loads one polygon of a block of polygons; shuffles pass
// it on to all invocations.
//   In: active_tiles, lists, projected, corners, polygons, fragments
//   Out: counters; unfinished tiles, with the layers that their samples have reached
// The shader has these parts: peel_state.glsl has its variants, samples and structs; slice.glsl finds the samples of
// scanlines; peel_tile.glsl finds the tile and loads its samples; peel_polygon.glsl tests samples against polygons and
// keeps layers; gaps.glsl counts gaps.
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "texels.glsl"
#include "counters.glsl"

#include "peel_state.glsl"
#include "subgroup.glsl"
#include "slice.glsl"
#include "gaps.glsl"

// Counts, for blocked pairs with scanlines, on which parts of the rows two polygons face each other, whatever lies
// between them. The spans that may be the nearer of a pair are the first `ups`; it takes them from number `from` on, as
// far as args.most_blocks allows. Returns the number of the first span that it has not taken.
uint meetSpans(Tile tile, uint from, uint ups, uint span_count, inout uint blocks_done, inout bool cut);

#include "peel_tile.glsl"
#include "peel_polygon.glsl"

// Returns whether an open sample of this invocation has kLayersKept layers, so that there is no room for another.
bool isFull() {
  bool full = false;
  [[unroll]] for (int k = 0; k < kMostSteps; ++k) full =
      full || (k < kSteps && open[k] && nearest[k][kLayersKept - 1] != kNoLayer);
  return full;
}

// Returns a bound: layers before it are settled, which means that no list entry from `next` on can come before them. In
// a sorted list no later polygon is nearer than the nearest depth of entry `next` in the tile.
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

// Tests the samples against the polygons from list_begin to list_end and adds the gaps between their layers. Where
// lists are sorted and a sample has no room for another layer, the gaps between settled layers are added first, which
// makes room.
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
    // Where no layer could be added and removed, the remaining list is taken without a stop, and the next round finds
    // the layers without room. Otherwise the loop would stop after every polygon.
    if (kSorted) patience = anyOf(isFull()) ? list_end : 0u;
  } while (base < list_end);
  cut = cut || base < list_end;
  tally.tested += kScanlines ? passed : list_end;
}

// Closes the samples whose layers have all been added, and the samples whose further layers cannot be in a pair that
// counts. Returns whether the subgroup has open samples left.
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

// Adds the subgroup's work to the batch's status.
//   In: begins: whether this dispatch is the first to peel the tile; only then rows and spans are added
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
  bool cut = false;  // whether the device ended a loop before its condition was false
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
  // The samples are tested against this part of the tile's list or, with scanlines, of `window`.
  uint list_begin = 0u, list_end = kScanlines ? 0u : polygon_count;
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
