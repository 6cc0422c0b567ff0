#version 460
// One instance is one polygon, a strip of four vertices, seen from the eye in one face of a hemicube. Its depth is
// kNear over the distance along the view axis, which is 0 at infinity.
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "hemicube_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Corners { CornerData at[]; };
layout(push_constant, scalar) uniform Args { HemicubeDraw args; };
layout(location = 0) flat out uint seen;  // 1 + the polygon's index where the eye sees its front, else kBack

const float kNear = 1e-8;  // unit-ball units; depths are floats near 0, so that none is lost
const uint kBack = 0xFFFFFFFFu;

void main() {
  PolygonData polygon = Polygons(args.polygons).at[gl_InstanceIndex];
  Corners corners = Corners(args.corners);
  dvec3 first = corners.at[polygon.first_corner].at;
  dvec3 front =
      cross(corners.at[polygon.first_corner + 1u].at - first, corners.at[polygon.first_corner + 2u].at - first);
  seen = dot(front, args.eye - first) > 0.0lf ? uint(gl_InstanceIndex) + 1u : kBack;
  uint corner = min(gl_VertexIndex < 2 ? gl_VertexIndex : 5 - gl_VertexIndex,
                    polygon.corner_count - 1u);  // corners 0 1 3 2, or 0 1 2 2 of a triangle
  vec3 line = vec3(corners.at[polygon.first_corner + corner].at - args.eye);
  float depth = dot(args.forward, line);
  gl_Position = vec4(dot(args.right, line), args.up_scale * dot(args.up, line) - args.up_shift * depth, kNear, depth);
}
