#version 460
// One instance is one polygon in one direction: a strip of four vertices around the pixels of all lattice points that
// the polygon can cover. All four are one point where the previous layer is empty there, so that nothing is drawn.
//   In: Outline outlines[direction_count][polygon_count], alive     Out: gl_Position; instance
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(push_constant, scalar) uniform Args { DrawArgs args; };
layout(location = 0) flat out uint instance;

void main() {
  uint direction_index = gl_InstanceIndex / args.polygon_count;
  instance = gl_InstanceIndex;
  gl_Position = vec4(0, 0, 0, 1);
  uvec2 alive = uvec2(Words(args.alive).at[2u * direction_index], Words(args.alive).at[2u * direction_index + 1u]);
  if (all(equal(alive & unpack32(Outlines(args.outlines).at[gl_InstanceIndex].blocks), uvec2(0)))) return;
  ivec2 cell = ivec2(direction_index % args.cells_per_row, direction_index / args.cells_per_row) * int(args.cell_size);
  vec2 point = Outlines(args.outlines).at[gl_InstanceIndex].strip[gl_VertexIndex];
  vec2 pixel = vec2(cell + int(args.cell_size) / 2) + point + 0.5;  // a pixel's centre is its lattice point
  gl_Position.xy = pixel / vec2(args.image_width, args.image_height) * 2.0 - 1.0;
}
