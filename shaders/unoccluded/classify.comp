#version 460
// One invocation chooses how one pair of sides is integrated: not at all (its area stays 0), by a product rule, or
// along its contours.
//   In: shapes, pairs     Out: lists of the pairs that see each other
//
// The bound on a product rule's error, with its derivation, is docs/method.md, eq. (37). Source: Gegenbauer's
// generating function, Abramowitz & Stegun, 22.9.3 and 22.14.2.
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { ClassifyArgs pushed; };
ClassifyArgs args;

// Returns the largest |slope| / value at the middle of an edge of the square, of a bilinear function given at its
// corners.
float slopeOf(dvec4 at) {
  dvec4 next = at.yzwx;
  vec4 difference = vec4(abs(at - next)), sum = vec4(at + next);
  float slope = 0.0;
  [[unroll]] for (int k = 0; k < 4; ++k) slope =
      max(slope, difference[k] >= sum[k] ? (difference[k] > 0.0 ? 1.0 : 0.0) : difference[k] / sum[k]);
  return slope;
}

// Coordinates holds the terms of the bound on the relative error over a polygon's two coordinates. Single precision:
// its rounding is 1e-6 of the bound.
struct Coordinates {
  float t, square, power;  // t, t^2, t^(2n - 2)
  float slopes, product;   // s + j, s j
  float factor;            // 2 (1 + t)^4 / (1 - s j / 3)
};

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

// The sums over k are less than their first terms times 1 / (1 - tail t^2) <= 1 + 2 tail t^2, while that is at most 2.
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
