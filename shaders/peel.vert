#version 460
// One instance is one polygon in one direction: four vertices span the pixels of the lattice points it can cover.
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(push_constant, scalar) uniform Args { PeelArgs args; };
layout(location = 0) flat out uint instance;

void main() {
  uint direction_index = gl_InstanceIndex / args.polygon_count;
  ProjectedPolygon polygon = Projected(args.projected).at[gl_InstanceIndex];
  instance = gl_InstanceIndex;
  gl_Position = vec4(0, 0, 0, 1);
  if (polygon.box_min.x > polygon.box_max.x || Words(args.alive).at[direction_index] == 0u) return;
  ivec2 cell = ivec2(direction_index % args.cells_per_row, direction_index / args.cells_per_row) * int(args.cell_size);
  ivec2 corner = ivec2((gl_VertexIndex & 1) != 0 ? polygon.box_max.x + 1 : polygon.box_min.x,
                       (gl_VertexIndex & 2) != 0 ? polygon.box_max.y + 1 : polygon.box_min.y);
  vec2 pixel = vec2(cell + corner + int(args.cell_size) / 2);
  gl_Position.xy = pixel / vec2(args.image_width, args.image_height) * 2.0 - 1.0;
}
