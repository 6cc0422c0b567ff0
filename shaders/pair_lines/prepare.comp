#version 460
#extension GL_GOOGLE_include_directive : require
// One invocation prepares one task. It writes the two patches as ends of lines, in single precision about the middle of
// the smaller patch. For tasks by angles it adds the rectangle around the second patch, and the warps that make points
// of the first patch denser where the second one looks larger. Twins: host/pair_lines/line_ends.cpp, draw_lines.cpp.
//   In: LineTaskData tasks[task_count], PatchData patches[]    Out: LinePairData pairs[task_count]
#include "pair_lines.glsl"

layout(local_size_x = kPairLinesGroup) in;
layout(push_constant, scalar) uniform Push { PrepareArgs pushed; };

LineEndData makeLineEnd(PatchData patch_, dvec3 origin, bool folds) {
  LineEndData end;
  bool is_folded = patch_.corner_count == 3u && folds;
  end.is_folded = is_folded ? 1u : 0u;
  dvec3 last = patch_.corner_count == 3u ? patch_.corners[0] : patch_.corners[3];
  precise dvec3 corner = patch_.corners[0] - origin, side_a = patch_.corners[1] - patch_.corners[0],
                side_b = (is_folded ? patch_.corners[2] : last) - patch_.corners[0],
                twist = patch_.corners[0] - patch_.corners[1] + patch_.corners[2] - last;
  if (is_folded) twist = dvec3(0);
  end.corner = vec3(corner), end.side_a = vec3(side_a), end.side_b = vec3(side_b), end.twist = vec3(twist);
  precise double area = dotInOrder(patch_.across, crossOf(side_a, side_b)) * (is_folded ? 0.5LF : 1.0LF);
  end.density = vec3(float(area), float(dotInOrder(patch_.across, crossOf(side_a, twist))),
                     float(dotInOrder(patch_.across, crossOf(twist, side_b))));
  end.normal = vec3(patch_.normal);
  precise double offset = patch_.offset - dotInOrder(patch_.normal, origin);
  end.offset = float(offset);
  end.edge_count = patch_.corner_count;
  [[unroll]] for (uint e = 0u; e < 4u; ++e) {
    precise double beyond = dotInOrder(patch_.edge_normals[e], origin) - patch_.edge_offsets[e];
    end.edges[e] = vec4(vec3(patch_.edge_normals[e]), float(beyond));
  }
  return end;
}

void frameSecond(inout LinePairData pair, vec3 corners[4], uint count) {
  vec3 seen[8];
  uint seen_count = 0u;
  vec3 longest = vec3(0);
  float longest_square = 0.0;
  bool is_cut = false;
  for (uint k = 0u; k < count; ++k) {
    vec3 p = corners[k], q = corners[k + 1u < count ? k + 1u : 0u];
    precise vec3 along = q - p;
    float square = dotInOrder(along, along);
    if (square > longest_square) longest = along, longest_square = square;
    precise float over_p = dotInOrder(pair.first.normal, p) - pair.first.offset,
                  over_q = dotInOrder(pair.first.normal, q) - pair.first.offset;
    if (over_p >= 0.0) seen[seen_count++] = p;
    else is_cut = true;
    if ((over_p > 0.0 && over_q < 0.0) || (over_p < 0.0 && over_q > 0.0)) {
      precise float fall = over_p - over_q;
      fall = fall < 0.0 ? -fall : fall;
      precise float at = over_p * reciprocal(greatest(fall, kLeast)) * (over_p > 0.0 ? 1.0 : -1.0);
      precise vec3 crossing = p + at * along;
      seen[seen_count++] = crossing;
    }
  }
  precise vec3 fold = crossOf(pair.first.normal, pair.second.normal);
  precise vec3 axis = is_cut && dotInOrder(fold, fold) >= kParallelSquare ? fold : longest;
  float inverse = inverseRoot(greatest(dotInOrder(axis, axis), kLeastSquare));
  axis = axis * inverse;
  pair.axes[0] = axis;
  pair.axes[1] = crossOf(pair.second.normal, axis);
  for (uint k = 0u; k < 2u; ++k) {
    vec2 range = vec2(kFarAway, -kFarAway);
    for (uint c = 0u; c < seen_count; ++c) {
      float at = dotInOrder(pair.axes[k], seen[c]);
      range = vec2(least(range.x, at), greatest(range.y, at));
    }
    pair.ranges[k] = range;
  }
}

precise float pointFormFactor(vec3 p, vec3 normal, vec3 corners[4], uint count) {
  precise float sum = 0.0;
  for (uint k = 0u; k < count; ++k) {
    precise vec3 a = corners[k] - p, b = corners[k + 1u < count ? k + 1u : 0u] - p;
    precise vec3 across = crossOf(a, b);
    precise float square = greatest(dotInOrder(across, across), kLeastSquare), inverse = inverseRoot(square);
    precise float sine = square * inverse, cosine = dotInOrder(a, b), size = cosine < 0.0 ? -cosine : cosine;
    precise float angle = arcTangent(sine, greatest(size, kLeastSquare));
    sum = sum + dotInOrder(normal, across) * inverse * (cosine < 0.0 ? kHalfTurn - angle : angle);
  }
  precise float share = (sum < 0.0 ? -sum : sum) * kInverseTurn;
  return share;
}

void warpTowards(inout LinePairData pair, vec3 corners[4], uint count) {
  precise float sums[2 * kWarpBins];
  for (uint k = 0u; k < 2u * kWarpBins; ++k) sums[k] = 0.0;
  for (uint row = 0u; row < kWarpBins; ++row)
    for (uint column = 0u; column < kWarpBins; ++column) {
      precise float s = (float(row) + 0.5) * 0.125, t = (float(column) + 0.5) * 0.125;
      float density;
      vec3 p = pointOn(pair.first, s, t, density);
      precise float over = dotInOrder(pair.second.normal, p) - pair.second.offset;
      precise float share = pointFormFactor(p, pair.first.normal, corners, count) * density;
      share = over > 0.0 ? share : 0.0;
      sums[row] = sums[row] + share;
      sums[kWarpBins + column] = sums[kWarpBins + column] + share;
    }
  precise float all_shares = 0.0;
  for (uint row = 0u; row < kWarpBins; ++row) all_shares = all_shares + sums[row];
  bool is_seen = all_shares > kLeastSquare;
  precise float part = kUnevenShare * reciprocal(greatest(all_shares, kLeastSquare));
  for (uint axis = 0u; axis < 2u; ++axis) {
    precise float start = 0.0;
    for (uint k = axis * kWarpBins; k < (axis + 1u) * kWarpBins; ++k) {
      precise float share = is_seen ? kEvenShare * 0.125 + part * sums[k] : 0.125;
      precise float wide = 8.0 * share;
      pair.starts[k] = start;
      pair.scales[k] = reciprocal(wide);
      start = start + share;
    }
  }
}

void main() {
  PrepareArgs args = pushed;
  uint index = gl_GlobalInvocationID.x;
  if (index >= args.task_count) return;
  LineTaskData task = Tasks(args.tasks).at[index];
  PatchData small = Patches(args.patches).at[task.small], large = Patches(args.patches).at[task.large];
  LinePairData pair;
  pair.first = makeLineEnd(small, small.middle, task.way != kByAngles);
  pair.second = makeLineEnd(large, small.middle, true);
  if (task.way == kByAngles) {
    vec3 corners[4];
    [[unroll]] for (uint k = 0u; k < 4u; ++k) {
      precise dvec3 corner = large.corners[k] - small.middle;
      corners[k] = vec3(corner);
    }
    frameSecond(pair, corners, large.corner_count);
    warpTowards(pair, corners, large.corner_count);
  }
  Pairs(args.pairs).at[index] = pair;
}
