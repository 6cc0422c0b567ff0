#version 460
// One invocation adds the weight of one pixel to the sum of the polygon seen there.
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "hemicube_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { HemicubeSum args; };

void main() {
  uint in_cell = gl_GlobalInvocationID.x, hemicube = gl_WorkGroupID.y;
  if (in_cell >= args.cell_width * args.cell_height) return;
  uint x = hemicube % args.cells_per_row * args.cell_width + in_cell % args.cell_width;
  uint y = hemicube / args.cells_per_row * args.cell_height + in_cell / args.cell_width;
  uint seen = Words(args.pixels).at[y * args.image_width + x];
  if (seen == 0u || seen > args.polygon_count) return;
  atomicAdd(Words(args.sums).at[hemicube * args.polygon_count + seen - 1u], Words(args.weights).at[in_cell]);
}
