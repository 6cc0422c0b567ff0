#version 460
// One workgroup, meant to be one subgroup, peels one row of one tile: each invocation takes one sample (a lattice point, or an interval of a
// scanline) and keeps the kLayersKept nearest layers behind those of the round before in registers; it adds what the gaps
// between consecutive layers contribute to the counters, and goes round again where more layers remain. The row's spans
// are loaded one by each invocation and passed on by shuffles.
//   In: rows, spans, samples, projected, polygons, directions     Out: counters, unfinished rows and the layers that they reached
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
#include "counters.glsl"

layout(local_size_x_id = 0) in;  // the subgroup size, 8 to 64
layout(constant_id = 1) const int kLayersKept = 4;
layout(constant_id = 2) const bool kScanlines = false;
layout(constant_id = 3) const bool kSparse = false;      // counters in a hash table
layout(constant_id = 4) const bool kAllCount = true;     // every polygon emits and receives
layout(constant_id = 5) const bool kAggregates = true;   // adds runs of equal contributions at once
layout(constant_id = 6) const bool kMeasuresWork = false;
layout(push_constant, scalar) uniform Args { PeelArgs args; };

const uint64_t kNoLayer = ~0ul;  // a layer is key << 32 | polygon + 1, so that layers are ordered as numbers

uint sideOf(uint64_t layer, bool above) {
  if (layer == 0ul || layer == kNoLayer) return kSideNone;
  return sideTowardsGap((layer >> 32 & 1ul) == 0ul, args.two_sided != 0u, above);
}

// Adds up what lanes with the same counter have, for runs of neighbouring lanes: the first of a run adds for all.
void addRuns(bool has, uvec2 pair, uint weight, uint lane) {
  if (kAggregates) {
    const uint lanes = gl_WorkGroupSize.x;
    uvec2 key = has ? pair : uvec2(~0u);
    uvec2 before = subgroupShuffle(key, max(lane, 1u) - 1u);
    bool head = lane == 0u || key != before;
    uint end = head ? lane : lanes;  // of the run before: where the next one begins
    end = lane + 1u < lanes ? subgroupShuffle(end, min(lane + 1u, lanes - 1u)) : lanes;
    uint sum = weight;
    [[unroll]] for (uint step = 1u; step < lanes; step *= 2u) {
      uint next_end = subgroupShuffle(end, min(lane + step, lanes - 1u));
      end = lane + step < lanes ? min(end, next_end) : end;
      uint other = subgroupShuffle(sum, max(lane, step) - step);
      sum += lane >= step ? other : 0u;
    }
    uint to_end = subgroupShuffle(sum, end - 1u);
    has = has && head;
    weight = to_end - sum + weight;
  }
  if (has) addCount(args.counters, args.counter_keys, args.counter_mask, args.status, args.id_count, kSparse, pair, weight);
}

// What the gap between two consecutive layers is counted for, if anything.
bool isCounted(uint gap, uint lower_id, uint upper_id) {
  if (kAllCount) return gap != kGapNothing;
  uint lower_roles = lower_id >> kRolesShift, upper_roles = upper_id >> kRolesShift;
  if (gap == kGapFacingPair) return ((lower_roles & kEmits) != 0u && (upper_roles & kReceives) != 0u) || ((upper_roles & kEmits) != 0u && (lower_roles & kReceives) != 0u);
  if (gap == kGapNothing || args.counts_environment == 0u) return false;
  return ((gap == kGapLowerEnvironment || gap == kGapLowerLeak ? lower_roles : upper_roles) & kEmits) != 0u;
}

void main() {
  const uint lanes = gl_WorkGroupSize.x;
  uint lane = gl_SubgroupInvocationID;
  uint place = gl_WorkGroupID.y * kGroupsPerRow + gl_WorkGroupID.x;
  Status status = Status(args.status);
  if ((status.at.overflows & (kListsOverflowed | kTileCut)) != 0u) return;
  if (place >= (args.resumes != 0u ? args.resumes : status.at.rows)) return;
  uvec4 row = texelFetch(row_texels, int(2u * place));         // span_start, span_count, sample_count, direction
  uvec4 where = texelFetch(row_texels, int(2u * place + 1u));  // column, row, first_sample, resume
  uint direction_weight = Directions(args.directions).at[row.w].weight;
  uint blocks_done = 0u, rounds = 0u, fragments = 0u, gaps = 0u;
  uint first = where.z, resume = where.w;
  bool cut = false;  // a loop ended before its time
  do {
    uint sample_index = first + lane;
    bool open = sample_index < row.z;  // whether the line may meet more layers
    int column = int(sample_index);
    uint weight = direction_weight;
    if (kScanlines) {
      uint at = 2u * row.x + min(sample_index, row.z - 1u);
      int from = int(texelFetch(sample_texels, int(at)).x), to = int(texelFetch(sample_texels, int(at + 1u)).x);
      column = (from + to - 1) >> 1;  // the middle: where polygons meet at an end, depths tie
      weight *= uint(to - from);
    }
    uint64_t last = 0ul;  // the farthest layer of the rounds before
    if (resume != 0u) last = Longs(args.reached).at[resume - 1u + lane];
    resume = 0u;
    open = open && last != kNoLayer;
    bool again;
    do {
      if (blocks_done >= args.most_blocks) {  // the rest of the row goes to another dispatch
        uint index = 0u;
        if (lane == 0u) index = atomicAdd(status.at.unfinished, 1u);
        index = subgroupShuffle(index, 0u);
        Longs(args.reached_next).at[index * lanes + lane] = open ? last : kNoLayer;
        if (lane == 0u) {
          Row rest;
          rest.span_start = row.x;
          rest.span_count = row.y;
          rest.sample_count = row.z;
          rest.direction = row.w;
          rest.column = int(where.x);
          rest.row = int(where.y);
          rest.first_sample = first;
          rest.resume = index * lanes + 1u;
          Rows(args.unfinished).at[index] = rest;
        }
        return;
      }
      uint64_t nearest[kLayersKept];
      [[unroll]] for (int k = 0; k < kLayersKept; ++k) nearest[k] = kNoLayer;
      uint64_t lost = kNoLayer;  // the nearest layer that found no room
      uint64_t farthest_emitter = 0ul, farthest_receiver = 0ul;
      uint base = 0u;
      do {
        // This invocation's span, and its polygon's depth at the tile's first column.
        uint mine = base + lane;
        uvec2 span = texelFetch(span_texels, int(row.x + min(mine, row.y - 1u))).xy;
        uint projected_at = 4u * (row.w * args.polygon_count + span.x);
        uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u));
        uvec4 depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
        uvec2 rest = texelFetch(projected_texels, int(projected_at + 3u)).xy;
        int64_t depth_x = longFrom(depth_01.zw);
        int64_t depth = longFrom(depth_01.xy) + depth_x * int64_t(int(where.x)) + longFrom(depth_2.xy) * int64_t(int(where.y));
        uvec4 plane = uvec4(unpackUint2x32(uint64_t(depth)), depth_01.zw);
        uvec4 bounds = uvec4(depth_2.zw, span.x + 1u, 2u * rest.x + rest.y);
        uint columns = mine < row.y ? span.y : 0xFFFFu;  // a span that no sample is in
        uint roles = kAllCount ? 0u : fetchId(span.x) >> kRolesShift;
        uint t = 0u;
        do {
          [[unroll]] for (uint four = 0u; four < 4u; ++four) {
            uint from = t + four;
            uint in_span = subgroupShuffle(columns, from);
            bool covered = uint(column) - (in_span & 0xFFFFu) <= in_span >> 16;
            uvec4 p = subgroupShuffle(plane, from), b = subgroupShuffle(bounds, from);
            int64_t z = (longFrom(p.xy) + (longFrom(p.zw) * int64_t(column) >> args.column_bits)) >> (b.w >> 1);
            uint key = 2u * uint(clamp(z, int64_t(int(b.x)), int64_t(int(b.y)))) + (1u - (b.w & 1u));
            uint64_t layer = packUint2x32(uvec2(b.z, key));
            if (!kAllCount) {
              uint its_roles = subgroupShuffle(roles, from);
              if (covered && (its_roles & kEmits) != 0u) farthest_emitter = max(farthest_emitter, layer);
              if (covered && (its_roles & kReceives) != 0u) farthest_receiver = max(farthest_receiver, layer);
            }
            if (kMeasuresWork) fragments += covered && last == 0ul ? 1u : 0u;
            layer = covered && layer > last ? layer : kNoLayer;
            [[unroll]] for (int k = 0; k < kLayersKept; ++k) {
              uint64_t farther = max(nearest[k], layer);
              nearest[k] = min(nearest[k], layer);
              layer = farther;
            }
            lost = min(lost, layer);
          }
          t += 4u;
        } while (t < lanes && base + t < row.y);
        cut = cut || (t < lanes && base + t < row.y);
        base += lanes;
        ++blocks_done;
      } while (base < row.y);
      cut = cut || base < row.y;
      ++rounds;

      // The gaps below the layers kept and, where none was lost, the one above the last.
      uint64_t lower = last;
      uint lower_id = lower == 0ul ? 0u : fetchId(uint(lower) - 1u);
      bool counting = open;
      uint kept = 0u;
      bool more;
      do {
        uint64_t upper = nearest[0];
        [[unroll]] for (int k = 0; k + 1 < kLayersKept; ++k) nearest[k] = nearest[k + 1];
        nearest[kLayersKept - 1] = kNoLayer;
        uint upper_id = upper == kNoLayer ? 0u : fetchId(uint(upper) - 1u);
        uint gap = classifyGap(sideOf(lower, true), sideOf(upper, false));
        bool counted = counting && isCounted(gap, lower_id, upper_id);
        addRuns(counted, pairOf(gap, lower_id & kIdMask, upper_id & kIdMask), weight, lane);
        if (kMeasuresWork) gaps += counted ? 1u : 0u;
        counting = counting && upper != kNoLayer;
        lower = upper != kNoLayer ? upper : lower;
        lower_id = upper_id;
        ++kept;
        // After the last of the layers kept comes the scene's end, unless a layer was lost.
        more = counting && (kept < uint(kLayersKept) || (kept == uint(kLayersKept) && lost == kNoLayer));
        counting = more;
      } while (subgroupAny(more));
      cut = cut || more;
      open = open && lost != kNoLayer;
      if (!kAllCount) open = open && lower <= (args.counts_environment != 0u ? farthest_emitter : min(farthest_emitter, farthest_receiver));
      last = lower;
      again = subgroupAny(open);
    } while (again);
    cut = cut || open;
    first += lanes;
  } while (first < row.z);
  if (cut || first < row.z) atomicOr(status.at.overflows, kRowCut);
  if (kMeasuresWork) {
    uint samples = where.z == 0u && where.w == 0u ? row.z : 0u;
    uint all_fragments = subgroupAdd(fragments), all_gaps = subgroupAdd(gaps);
    if (lane == 0u) {
      atomicAdd(status.at.spans, uint64_t(samples != 0u ? row.y : 0u));
      atomicAdd(status.at.samples, uint64_t(samples));
      atomicAdd(status.at.rounds, uint64_t(rounds));
      atomicAdd(status.at.tests, uint64_t(rounds) * uint64_t(row.y) * uint64_t(lanes));
      atomicAdd(status.at.fragments, uint64_t(all_fragments));
      atomicAdd(status.at.gaps, uint64_t(all_gaps));
    }
  }
}
