#version 460
// Each polygon of a pair is cut to its part in front of the other's plane, and the integral is over the two parts. One
// invocation takes one edge of the first part with each edge of the second part. It chooses the rule for the line
// integral over these two edges.
//   In: shapes, pairs, near     Out: edges; lists, of pairs of edges, by rule; values: 0, with bounds on their errors
//   Source: I. E. Sutherland & G. W. Hodgman, Reentrant polygon clipping, CACM 17(1), 1974.
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { EdgesArgs pushed; };
EdgesArgs args;

// Returns the edges of the part of a polygon in front of a plane: the remains of the polygon's edges, then the edge
// along the plane. They run around the part as the polygon's corners do. Corners within `rounding` of the plane are
// kept.
//   In: depths: the corners' depths over the plane; origin: the edges are in coordinates about this point
EdgeData[kMostEdges] frontEdges(ShapeData shape, dvec4 depths, double rounding, dvec3 origin) {
  EdgeData edges[kMostEdges];
  dvec3 leaves = dvec3(0.0LF), enters = dvec3(0.0LF);
  [[unroll]] for (int k = 0; k < 4; ++k) {
    dvec3 start = shape.corners[k] - origin, end = shape.corners[(k + 1) & 3] - origin;
    double from = depths[k], to = depths[(k + 1) & 3];
    bool starts = from >= -rounding, ends = to >= -rounding;
    bool crosses = (from > rounding && !ends) || (!starts && to > rounding);
    // Where an edge crosses the plane at a corner, within rounding, that corner is taken for the crossing.
    dvec3 crossing = crosses ? start + (end - start) * (from / (from - to)) : starts ? start : end;
    if (starts && !ends) leaves = crossing;
    if (!starts && ends) enters = crossing;
    dvec3 first = starts ? start : crossing, last = ends ? end : crossing;
    edges[k] = EdgeData(first, starts || ends ? last - first : dvec3(0.0LF));
  }
  edges[4] = EdgeData(leaves, enters - leaves);
  return edges;
}

EdgeData select(EdgeData edges[kMostEdges], uint index) {
  EdgeData edge = edges[0];
  [[unroll]] for (uint k = 1u; k < kMostEdges; ++k) if (index == k) edge = edges[k];
  return edge;
}

// Returns the number of the rule for a pair of edges.
//   In: together: p . q    Out: error: bound on the rule's error
uint chooseRule(EdgeData p, EdgeData q, double together, out double error) {
  double square_p = dot(p.along, p.along), square_q = dot(q.along, q.along);
  if (square_p > square_q) {
    EdgeData other = p;
    p = q;
    q = other;
    double s = square_p;
    square_p = square_q;
    square_q = s;
  }
  // The inner integral, over the longer edge q, is analytic up to this distance (`clear`) from the middle of p, in
  // units of half the length of p.
  dvec3 from = p.start + 0.5LF * p.along - q.start;
  dvec3 off = from - q.along * clamp(dot(from, q.along) / square_q, 0.0LF, 1.0LF);
  double clear = 2.0LF * sqrt(dot(off, off) / square_p);
  uint rule = clear > 12.0LF ? 0u : clear > 3.5LF ? 1u : clear > 1.5LF ? 2u : kGradedRule;
  double axes = clear + sqrt(max(clear * clear - 1.0LF, 0.0LF)), shrinks = 1.0LF / (axes * axes), plain_error = 4.0LF;
  for (uint k = 0u; k < args.plain_points[0]; ++k) plain_error *= shrinks;
  if (rule != 0u)
    for (uint k = args.plain_points[0]; k < args.plain_points[min(rule, 2u)]; ++k) plain_error *= shrinks;
  error = (rule < kGradedRule ? plain_error : args.graded_error) * abs(together);
  return rule;
}

void main() {
  args = pushed;
  uint entry = gl_GlobalInvocationID.x / kMostEdges, index = gl_GlobalInvocationID.x % kMostEdges;
  if (entry >= args.near_count) return;
  Sides sides = loadSides(args.pairs, Words(args.near).at[entry]);
  dvec3 origin = meanCorner(sides.a);
  double distance = length(meanCorner(sides.b) - origin);
  dvec4 depths_a = depthsOf(sides.a, sides.b, sides.normal_b), depths_b = depthsOf(sides.b, sides.a, sides.normal_a);
  if (areTouching(sides)) depths_a = depths_b = dvec4(1.0LF);  // touching polygons: nothing is cut off
  EdgeData edges_a[kMostEdges] =
      frontEdges(sides.a, depths_a, depthRounding(sides.b, distance + sides.a.radius), origin);
  EdgeData edges_b[kMostEdges] =
      frontEdges(sides.b, depths_b, depthRounding(sides.a, distance + sides.b.radius), origin);
  EdgeData p = select(edges_a, index);
  Edges edges = Edges(args.edges);
  edges.at[2u * kMostEdges * entry + index] = p;
  edges.at[2u * kMostEdges * entry + kMostEdges + index] = select(edges_b, index);

  [[unroll]] for (uint k = 0u; k < kMostEdges; ++k) {
    uint slot = entry * kEdgePairs + index * kMostEdges + k;
    EdgeData q = edges_b[k];
    double together = dot(p.along, q.along), error = 0.0LF;
    bool adds = together != 0.0LF;
    if (adds) {
      uint rule = chooseRule(p, q, together, error);
      uint at = append(Work(args.work + uint64_t(rule) * kWorkListBytes));
      Words(args.lists).at[rule * args.near_count * kEdgePairs + at] = slot;
    }
    LineValues(args.values).at[slot] = LineValue(0.0LF, adds ? error : 0.0LF);
  }
}
