#version 460
// One invocation chooses how one pair of sides is integrated: not at all (its area stays 0), by a product rule, or
// along its contours.
//   In: shapes, pairs     Out: lists, of the pairs that can see each other, by the way of integration
//
// docs/method.md derives the bound on a product rule's error, eq. (37). Source: Gegenbauer's generating function,
// Abramowitz & Stegun, 22.9.3 and 22.14.2.
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { ClassifyArgs pushed; };
ClassifyArgs args;

// Returns the largest |slope| / value at the middles of the square's edges, at most 1: of a bilinear function on the
//   square, along each edge. In: at: its values at the corners, where the sum of two neighbours is not negative
float slopeOf(dvec4 at) {
  dvec4 next = at.yzwx;
  vec4 difference = vec4(abs(at - next)), sum = vec4(at + next);
  float slope = 0.0;
  [[unroll]] for (int k = 0; k < 4; ++k) slope =
      max(slope, difference[k] >= sum[k] ? (difference[k] > 0.0 ? 1.0 : 0.0) : difference[k] / sum[k]);
  return slope;
}

// Coordinates has the terms of the error bound, docs/method.md, eq. (37), that u and v of one polygon share. In single
// precision they are rounded by 1e-6 of the bound.
struct Coordinates {
  float t, square, power;  // t of eq. (37), t^2 and, for a rule of n points, t^(2n - 2)
  float slopes, product;   // s + j and s j
  float factor;            // 2 (1 + t)^4 / (1 - s j / 3)
};

// Returns these terms of a polygon, for the rule of fewest points.
//   In: distance: between the middles of the two polygons; other_radius: the other polygon's radius; slope: see slopeOf
Coordinates coordinatesOf(ShapeData shape, double distance, double other_radius, float slope) {
  Coordinates c;
  c.t = float(shape.reach) / float(max(distance - shape.reach - other_radius, shape.reach));
  c.square = c.power = c.t * c.t;
  float skew = float(shape.skew), stretch = (1.0 + c.t) * (1.0 + c.t);
  c.slopes = slope + skew;
  c.product = slope * skew;
  c.factor = 2.0 * stretch * stretch / (1.0 - c.product / 3.0);
  return c;
}

// Returns the bound of eq. (37) on the relative error of a rule over u and v of one polygon, or 1 where the bound is
// useless. Each sum over k in it is at most its first term / (1 - tail t^2), where FarBound::tail bounds the ratio of
// consecutive terms by tail t^2. That quotient is at most 1 + 2 tail t^2 while tail t^2 <= 1/2.
float errorOf(FarBound rule, Coordinates c) {
  float rest = rule.tail * c.square, series = rule.even * c.square + rule.odd * c.slopes * c.t + rule.skew * c.product;
  return rest < 0.5 ? c.factor * c.power * series * (1.0 + 2.0 * rest) : 1.0;
}

void main() {
  args = pushed;
  uint pair = gl_GlobalInvocationID.x;
  if (pair >= args.pair_count) return;
  Sides sides = loadSides(args.pairs, pair);
  double distance = length(meanCorner(sides.b) - meanCorner(sides.a));
  dvec4 depths_a = depthsOf(sides.a, sides.b, sides.normal_b), depths_b = depthsOf(sides.b, sides.a, sides.normal_a);
  double rounding_a = depthRounding(sides.b, distance + sides.a.radius),
         rounding_b = depthRounding(sides.a, distance + sides.b.radius);

  bool is_seen = greatestOf(depths_a) > rounding_a && greatestOf(depths_b) > rounding_b;
  if ((sides.a.plane >> 1) == (sides.b.plane >> 1))
    is_seen = areTouching(sides) && distance < sides.a.radius + sides.b.radius && !sides.are_one;
  bool is_whole = leastOf(depths_a) > 0.0LF && leastOf(depths_b) > 0.0LF && !areTouching(sides);

  Coordinates over_a = coordinatesOf(sides.a, distance, sides.b.radius, slopeOf(depths_a));
  Coordinates over_b = coordinatesOf(sides.b, distance, sides.a.radius, slopeOf(depths_b));
  uint rule = kNearList;
  [[unroll]] for (uint k = 0u; k < kFarRules; ++k) {
    if (errorOf(args.bounds[k], over_a) + errorOf(args.bounds[k], over_b) <= kFarError) rule = min(rule, k);
    over_a.power *= over_a.square;
    over_b.power *= over_b.square;
  }

  if (!is_seen) return;
  uint list = is_whole ? rule : kNearList;
  uint at = append(Work(args.work + uint64_t(list) * kWorkListBytes));
  Words(args.lists).at[list * args.pair_count + at] = pair;
}
