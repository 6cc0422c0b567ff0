// One workgroup, meant to be one subgroup, peels one tile, with scanlines some rows of it. Each invocation takes kSteps
// samples. It keeps in registers the kLayersKept nearest layers of each behind the layers of the round before. It adds
// the gaps between consecutive layers to the counters, and goes round again where more layers remain. A sample is a
// lattice point or, with scanlines, the interval between two ends of spans. The order of polygons does not change in an
// interval, and its length is its weight. The tile's polygons are loaded one by each invocation and passed on by
// shuffles.
//   In: active_tiles, lists, projected, corners, polygons, fragments
//   Out: counters, unfinished tiles and the layers that they reached
// Parts of it are files: peel_state.glsl has its variants, samples and structs; slice.glsl the samples of scanlines;
// peel_tile.glsl the tile and its samples; peel_polygon.glsl takes polygons past samples; gaps.glsl counts.
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

// Adds up all meetings in the rows, of the spans that may be the nearer, the first `ups`, from the one `from` on, as
// far as one invocation may go. Returns how far it got. With scanlines peel_blocked.comp does it; peel.comp has nothing
// to do.
uint meetSpans(Tile tile, uint from, uint ups, uint span_count, inout uint blocks_done, inout bool cut);

#include "peel_tile.glsl"
#include "peel_polygon.glsl"

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
