#version 460
// One invocation projects one polygon along one direction: snaps its corners to the lattice's fixed point, finds the box of lattice
// points it can cover and writes its depth as a plane over the lattice.
//   In:  directions, polygons, corners (ProjectArgs)     Out: snapped, projected
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { ProjectArgs args; };

// The same sum in the same order on every device, which dot() does not promise.
double dotInOrder(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// floor(log2(x)) of a normal x > 0.
int exponentOf(double x) { return int((unpackDouble2x32(x).y >> 20) & 0x7FFu) - 1023; }

void main() {
  uint polygon_index = gl_GlobalInvocationID.x;
  uint direction_index = gl_WorkGroupID.y;
  if (polygon_index >= args.polygon_count || direction_index >= args.direction_count) return;
  DirectionData direction = Directions(args.directions).at[direction_index];
  PolygonData polygon = Polygons(args.polygons).at[polygon_index];
  Corners corners = Corners(args.corners);
  Snapped snapped = Snapped(args.snapped);
  uint corner_at = direction_index * args.corner_count + polygon.first_corner;

  // Corners in lattice coordinates, x / h + offset with 1 / h = resolution / 2.
  precise double per_spacing = double(args.resolution) * 0.5LF;
  precise double fixed_one = double(1 << args.fraction_bits);
  ivec2 low = ivec2(0x7FFFFFFF), high = -low;
  double z_min = 2.0LF, z_max = -2.0LF;
  int64_t twice_area = int64_t(0);
  ivec2 first, previous;
  for (uint k = 0u; k < polygon.corner_count; ++k) {
    dvec3 corner = corners.at[polygon.first_corner + k];
    precise double x = dotInOrder(corner, direction.x_axis) * per_spacing + direction.offset.x;
    precise double y = dotInOrder(corner, direction.y_axis) * per_spacing + direction.offset.y;
    ivec2 at = ivec2(int(floor(x * fixed_one + 0.5LF)), int(floor(y * fixed_one + 0.5LF)));
    snapped.at[corner_at + k] = at;
    low = min(low, at);
    high = max(high, at);
    precise double z = dotInOrder(corner, direction.u);
    z_min = min(z_min, z);
    z_max = max(z_max, z);
    if (k == 0u) first = at;
    else twice_area += int64_t(previous.x - first.x) * int64_t(at.y - first.y) - int64_t(previous.y - first.y) * int64_t(at.x - first.x);
    previous = at;
  }

  ProjectedPolygon projected;
  projected.front_up = twice_area > int64_t(0) ? 1u : 0u;
  int round_up = (1 << args.fraction_bits) - 1;
  projected.box_min = (low + round_up) >> args.fraction_bits;
  projected.box_max = high >> args.fraction_bits;
  if (twice_area == int64_t(0) || any(greaterThan(projected.box_min, projected.box_max))) {
    projected.box_min = ivec2(1);
    projected.box_max = ivec2(0);
  }

  // normal . (x, y, z) = plane_offset, solved for z at lattice points.
  precise double nx = dotInOrder(polygon.plane_normal, direction.x_axis);
  precise double ny = dotInOrder(polygon.plane_normal, direction.y_axis);
  precise double nz = dotInOrder(polygon.plane_normal, direction.u);
  precise double unit = double(1 << kDepthBits);
  precise double steepness = 1.0LF / max(abs(nz), 1e-30LF);
  precise double dx = -nx / (nz * per_spacing) * unit;
  precise double dy = -ny / (nz * per_spacing) * unit;
  precise double d0 = (polygon.plane_offset / nz + 1.0LF) * unit - dx * direction.offset.x - dy * direction.offset.y;
  double bound = abs(d0) + (abs(dx) + abs(dy)) * double(args.resolution) + 1.0LF;
  int exponent = exponentOf(bound);
  if (abs(nz) > 1e-12LF && exponent < 60) {
    projected.depth_shift = min(60 - exponent, 30);
    precise double scale = double(1 << projected.depth_shift);
    projected.depth_0 = int64_t(floor(d0 * scale + 0.5LF));
    projected.depth_x = int64_t(floor(dx * scale + 0.5LF));
    projected.depth_y = int64_t(floor(dy * scale + 0.5LF));
  } else {  // edge-on: what rounding lets it cover lies at its middle
    projected.depth_shift = 0;
    projected.depth_0 = int64_t((0.5LF * (z_min + z_max) + 1.0LF) * unit);
    projected.depth_x = projected.depth_y = int64_t(0);
  }
  // Corners lie within 1e-8 of their plane; the slack keeps the clamp from parting coplanar polygons.
  double slack = 4.0LF + 2.0LF * min(steepness, 1e6LF);
  projected.depth_min = int(max((z_min + 1.0LF) * unit - slack, 0.0LF));
  projected.depth_max = int(min((z_max + 1.0LF) * unit + slack, 2.0LF * unit));
  Projected(args.projected).at[direction_index * args.polygon_count + polygon_index] = projected;
}
