#version 460
// One invocation adds up the line integrals of one pair: A_i F_ij = 1 / (2 pi) oint_i oint_j ln r ds . dt. Points s and
// t run around the two polygons, at distance r of each other.
//   In: shapes, pairs, near, values
//   Out: areas; again: pairs that need rules with more points; unreached: pairs that are not accurate with the most
//     points
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { SumArgs pushed; };
SumArgs args;

void main() {
  args = pushed;
  uint entry = gl_GlobalInvocationID.x;
  if (entry >= args.near_count) return;
  uint pair = Words(args.near).at[entry];
  Sides sides = loadSides(args.pairs, pair);
  double sum = 0.0LF, error = 0.0LF;
  for (uint k = 0u; k < kEdgePairs; ++k) {
    LineValue value = LineValues(args.values).at[entry * kEdgePairs + k];
    sum += value.value;
    error += value.error;
  }
  error /= 2.0LF * kPi;
  double least = 1e-9LF * min(sides.a.area, sides.b.area);
  double area = (sides.is_flipped ? -sum : sum) / (2.0LF * kPi);
  bool is_reached = error <= max(least, 1e-6LF * area);
  // Polygons that lie in one plane, face to face, without an overlap exchange nothing.
  if (areTouching(sides) && area <= least) area = 0.0LF;
  Doubles(args.areas).at[pair] = max(area, 0.0LF);
  if (is_reached) return;
  Status status = Status(args.status);
  if (args.is_last == 0u) Words(args.again).at[atomicAdd(status.at.again, 1u)] = pair;
  else Unreached(args.unreached).at[atomicAdd(status.at.unreached, 1u)] = UnreachedData(error, pair, 0u);
}
