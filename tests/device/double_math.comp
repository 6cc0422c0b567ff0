#version 460
// One invocation evaluates double_math.glsl at one point.
//   In: points     Out: values: ln x, the angle of (x, y)
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "double_math.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Points { dvec2 at[]; };
layout(push_constant, scalar) uniform Args {
  uint64_t points, values;
  uint count;
}
args;

void main() {
  uint k = gl_GlobalInvocationID.x;
  if (k >= args.count) return;
  dvec2 p = Points(args.points).at[k];
  Points(args.values).at[k] = dvec2(logOf(abs(p.x)), angleOf(p.x, p.y));
}
