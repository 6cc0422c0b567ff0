// The kernels of pair lines share these functions. Each has a twin of the same name in host/pair_lines (lanes.h,
// line_ends.h), which says what it computes, and both return the same bits. Therefore they have no quotients and no
// roots, only `precise` sums, differences, products and comparisons, which all devices round alike.
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_control_flow_attributes : require
#include "pair_lines.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Patches { PatchData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Blockers { BlockerData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tasks { LineTaskData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Placed { PlacedData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Portions { LinePortionData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Sobol { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Pairs { LinePairData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Obstacles { ObstacleData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Sums { LinePortionSums at[]; };

precise float dotInOrder(vec3 a, vec3 b) {
  precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}
precise double dotInOrder(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}
precise vec3 crossOf(vec3 a, vec3 b) {
  precise vec3 across = vec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
  return across;
}
precise dvec3 crossOf(dvec3 a, dvec3 b) {
  precise dvec3 across = dvec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
  return across;
}

float least(float a, float b) { return a < b ? a : b; }
float greatest(float a, float b) { return a > b ? a : b; }

precise float reciprocal(float x) {
  precise float y = uintBitsToFloat(kReciprocalBits - floatBitsToUint(x));
  [[unroll]] for (int k = 0; k < 3; ++k) y = y * (2.0 - x * y);
  return y;
}

precise float inverseRoot(float x) {
  precise float y = uintBitsToFloat(kInverseRootBits - (floatBitsToUint(x) >> 1)), half_x = 0.5 * x;
  [[unroll]] for (int k = 0; k < 3; ++k) y = y * (1.5 - half_x * y * y);
  return y;
}

precise float tangent(float angle) {
  precise float a = 0.25 * angle, s = a * a;
  precise float x =
      a *
      (1.0 + s * (kTangent3 + s * (kTangent5 + s * (kTangent7 + s * (kTangent9 + s * (kTangent11 + s * kTangent13))))));
  precise float square = x * x, rest = 1.0 - square, below = rest * rest - 4.0 * square;
  precise float found = 4.0 * x * rest * reciprocal(greatest(below, kLeast));
  return found;
}

precise float arcTangent(float opposite, float adjacent) {
  precise float size = opposite < 0.0 ? -opposite : opposite;
  precise float over_large = size - kLargeTangent * adjacent, over_middle = size - kMiddleTangent * adjacent;
  precise float above = over_middle > 0.0 ? size - adjacent : size,
                below = over_middle > 0.0 ? size + adjacent : adjacent;
  above = over_large > 0.0 ? -adjacent : above;
  below = over_large > 0.0 ? size : below;
  float base = over_middle > 0.0 ? kEighthTurn : 0.0;
  base = over_large > 0.0 ? kQuarterTurn : base;
  precise float x = above * reciprocal(below), s = x * x;
  precise float angle = base + x + x * s * (kArcTangent3 + s * (kArcTangent5 + s * (kArcTangent7 + s * kArcTangent9)));
  return opposite < 0.0 ? -angle : angle;
}

precise vec3 pointOn(LineEndData of, float s_given, float t_given, out float density) {
  precise float s = s_given, t = t_given;
  if (of.is_folded != 0u) {
    precise float half_s = 0.5 * s, half_t = 0.5 * t, folded_s = t > s ? half_s : s - half_t;
    t = t > s ? t - half_s : half_t;
    s = folded_s;
  }
  precise float st = s * t, found = of.density.x + of.density.y * s + of.density.z * t;
  density = found;
  precise vec3 point = of.corner + of.side_a * s + of.side_b * t + of.twist * st;
  return point;
}
