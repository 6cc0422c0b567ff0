#version 460
#extension GL_GOOGLE_include_directive : require
// One invocation makes one obstacle: a blocker in single precision, in coordinates about the middle of the task's
// smaller patch. Its twin is makeObstacles in host/pair_lines/line_ends.cpp.
//   In: PlacedData placed[placed_count], LineTaskData tasks[], PatchData patches[], BlockerData blockers[]
//   Out: ObstacleData obstacles[placed_count]
#include "pair_lines.glsl"

layout(local_size_x = kPairLinesGroup) in;
layout(push_constant, scalar) uniform Push { PlaceArgs pushed; };

void main() {
  PlaceArgs args = pushed;
  uint index = gl_GlobalInvocationID.x;
  if (index >= args.placed_count) return;
  PlacedData placed = Placed(args.placed).at[index];
  dvec3 origin = Patches(args.patches).at[Tasks(args.tasks).at[placed.task].small].middle;
  BlockerData blocker = Blockers(args.blockers).at[placed.blocker];
  ObstacleData obstacle;
  obstacle.place = placed.place;
  obstacle.edge_count = blocker.corner_count;
  precise double over = dotInOrder(blocker.normal, origin) - blocker.offset;
  obstacle.plane = vec4(vec3(blocker.normal), float(over));
  [[unroll]] for (uint e = 0u; e < kMostObstacleEdges; ++e) {
    precise double beyond = dotInOrder(blocker.edge_normals[e], origin) - blocker.edge_offsets[e];
    obstacle.edges[e] = vec4(vec3(blocker.edge_normals[e]), float(beyond));
  }
  Obstacles(args.obstacles).at[index] = obstacle;
}
