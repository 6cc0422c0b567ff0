#version 460
// One invocation integrates ln r over one pair of edges p and q (docs/method.md, eq. 38). Here r is the distance of a
// point of p from a point of q. The inner integral, over the longer edge q, has a closed form; the outer one takes a
// Gauss rule. Where the edges are close (kIsGraded), p is cut at the points where the inner integral is singular, and
// the rule is graded towards both ends of each piece.
//   In: edges; list: pairs of edges; points     Out: values: value, and error, to which rounding is added
//   Source: E. M. Sparrow, A new and simpler formulation for radiative angle factors, J. Heat Transfer 85(2), 1963,
//     81-87.
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"
#include "double_math.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kIsGraded = true;
layout(push_constant, scalar) uniform Args { LineArgs pushed; };
LineArgs args;

const uint kMostPieces = 4u;
const double kUnit = 2.2e-16LF;  // relative rounding of double precision
const double kLeast = 1e-290LF;  // replaces 0 in arguments of logarithms and angles, whose factor is then 0 as well

// Returns the inner integral over q for one point of p.
//   In: from: the point less the start of q; direction: unit vector along q
//   Out: magnitude: the sum of the sizes of its terms, which may cancel
double innerIntegral(dvec3 from, dvec3 direction, double length_q, out double magnitude) {
  double along = dot(from, direction), rest = length_q - along;
  dvec3 across = cross(from, direction);
  double square = dot(across, across), d = sqrt(square);
  double first = 0.5LF * along * logOf(max(along * along + square, kLeast)),
         last = 0.5LF * rest * logOf(max(rest * rest + square, kLeast));
  double turn = d * angleOf(square - rest * along + kLeast, d * length_q);
  magnitude = abs(first) + abs(last) + turn;
  return first + last + turn;
}

// Returns 0, three places in order, and 1, as fractions of p: the ends of the pieces of p. At the places the inner
// integral is singular, or nearly so. Two of them are the feet of q's ends on the line of p. The third is the point of
// this line that is nearest to the line of q, if the nearest point there lies within q. Places beyond p are moved to
// its ends.
double[kMostPieces + 1u] cutsOf(EdgeData p, EdgeData q) {
  dvec3 from = q.start - p.start, across = cross(p.along, q.along);
  double per_p = 1.0LF / dot(p.along, p.along), first = dot(from, p.along) * per_p,
         last = first + dot(q.along, p.along) * per_p, nearest = 0.0LF;
  double sine = dot(across, across);
  if (sine > 0.0LF) {
    double foot = dot(cross(from, p.along), across) / sine;
    nearest = foot > 0.0LF && foot < 1.0LF ? dot(cross(from, q.along), across) / sine : 0.0LF;
  }
  dvec3 cuts = clamp(dvec3(first, last, nearest), 0.0LF, 1.0LF);
  double low = min(min(cuts.x, cuts.y), cuts.z), high = max(max(cuts.x, cuts.y), cuts.z);
  return double[](0.0LF, low, max(min(cuts.x, cuts.y), min(max(cuts.x, cuts.y), cuts.z)), high, 1.0LF);
}

void main() {
  args = pushed;
  uint entry = gl_GlobalInvocationID.x;
  if (entry >= Work(args.work).at.count) return;
  uint slot = Words(args.list).at[entry], in_pair = slot % kEdgePairs, first = slot / kEdgePairs * 2u * kMostEdges;
  EdgeData p = Edges(args.edges).at[first + in_pair / kMostEdges],
           q = Edges(args.edges).at[first + kMostEdges + in_pair % kMostEdges];
  if (dot(p.along, p.along) > dot(q.along, q.along)) {
    EdgeData other = p;
    p = q;
    q = other;
  }
  double cuts[kMostPieces + 1u] = double[](0.0LF, 1.0LF, 1.0LF, 1.0LF, 1.0LF);
  if (kIsGraded) cuts = cutsOf(p, q);
  double length_q = length(q.along);
  dvec3 direction = q.along / length_q, from = p.start - q.start;
  double sum = 0.0LF, greatest = 0.0LF, low = 0.0LF;
  do {
    // The piece ends at the next place that leaves it any length.
    double high = 1.0LF;
    [[unroll]] for (uint k = kMostPieces; k > 0u; --k) if (cuts[k] > low) high = cuts[k];
    double part = 0.0LF;
    for (uint k = 0u; k < args.point_count; ++k) {
      dvec2 point = fetchDoubles(args.first_point + k);
      double magnitude;
      part += point.y * innerIntegral(from + (low + point.x * (high - low)) * p.along, direction, length_q, magnitude);
      greatest = max(greatest, magnitude);
    }
    sum += (high - low) * part;
    low = high;
  } while (low < 1.0LF);
  double factor = dot(p.along, direction);
  LineValues(args.values).at[slot].value = factor * sum;
  LineValues(args.values).at[slot].error += kUnit * abs(factor) * greatest;
}
