#version 460
// One invocation takes one lattice point of one direction (graphics engine). It applies the facing rules to the gap
// between layers k-1 and k and adds one to the counter of the gap. Where layer k has a polygon, it requests layer k+1.
// Where blocked pairs are counted, it also adds one to the counter kFacingOrBlocked of every layer before k that faces
// layer k, whatever lies between the two.
//   In: polygons, layers     Out: counters, next_alive, next_commands
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_atomic_int64 : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "counters.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { AccumulateArgs args; };

// Returns the side that a layer turns to the gap above it, or below it.
uint sideOf(Layer layer, bool above) {
  if (layer.polygon == 0u) return kSideNone;
  return sideTowardsGap(!isFrontDown(layer.polygon), args.two_sided != 0u, above);
}

void main() {
  uint points_per_cell = args.cell_size * args.cell_size;
  uint direction_index = gl_WorkGroupID.y;
  uint in_cell = gl_GlobalInvocationID.x;
  if (in_cell >= points_per_cell) return;
  uint x = (direction_index % args.cells_per_row) * args.cell_size + in_cell % args.cell_size;
  uint y = (direction_index / args.cells_per_row) * args.cell_size + in_cell / args.cell_size;
  uint at = y * args.image_width + x;

  Layer lower = Layers(args.lower).at[at];
  Layer upper = Layers(args.upper).at[at];
  if (upper.polygon != 0u) {
    uint block = 8u * blockAlong(in_cell / args.cell_size, args.cell_size) +
                 blockAlong(in_cell % args.cell_size, args.cell_size);
    uint word = 2u * direction_index + block / 32u, bit = 1u << (block % 32u);
    if ((Words(args.next_alive).at[word] & bit) == 0u) atomicOr(Words(args.next_alive).at[word], bit);
    Commands next = Commands(args.next_commands);
    next.at.draw_instance_count = args.instance_count;
    next.at.group_count_x = args.group_count;
  }
  Polygons polygons = Polygons(args.polygons);
  Counters counters = Counters(args.counters, args.status, args.id_count, 0u, false, args.layers != 0ul ? 2u : 1u);
  uint upper_side = sideOf(upper, false);
  if (args.layers != 0ul && upper_side == kSideFront)
    for (uint k = 0u; k < args.layer; ++k) {
      Layer before = Layers(Longs(args.layers).at[k]).at[at];
      if (classifyGap(sideOf(before, true), upper_side) != kGapFacingPair) continue;
      uint id = polygons.at[layerPolygonOf(before.polygon) - 1u].id & kIdMask,
           upper_id = polygons.at[layerPolygonOf(upper.polygon) - 1u].id & kIdMask;
      addCount(counters, kFacingOrBlocked, pairOf(kGapFacingPair, id, upper_id), 1ul);
    }
  uint gap = classifyGap(sideOf(lower, true), upper_side);
  if (gap == kGapNothing) return;
  uint lower_id = lower.polygon == 0u ? 0u : polygons.at[layerPolygonOf(lower.polygon) - 1u].id & kIdMask;
  uint upper_id = upper.polygon == 0u ? 0u : polygons.at[layerPolygonOf(upper.polygon) - 1u].id & kIdMask;
  addCount(counters, kFacing, pairOf(gap, lower_id, upper_id), 1ul);
}
