// The passes project and enter share these functions, which project one polygon along one direction.
#include "geometry.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { ProjectArgs pushed; };
ProjectArgs args;
layout(binding = 0) uniform usamplerBuffer direction_texels;  // DirectionData
layout(binding = 1) uniform usamplerBuffer polygon_texels;    // PolygonData
layout(binding = 2) uniform usamplerBuffer corner_texels;     // CornerData

dvec2 doublesFrom(uvec4 texel) { return dvec2(packDouble2x32(texel.xy), packDouble2x32(texel.zw)); }

dvec3 fetchCorner(uint index) {
  return dvec3(doublesFrom(texelFetch(corner_texels, int(2u * index))),
               doublesFrom(texelFetch(corner_texels, int(2u * index + 1u))).x);
}

DirectionData fetchDirection(uint index) {
  int at = 6 * int(index);
  dvec2 d[6];
  for (int k = 0; k < 6; ++k) d[k] = doublesFrom(texelFetch(direction_texels, at + k));
  DirectionData direction;
  direction.x_axis = dvec3(d[0], d[1].x);
  direction.y_axis = dvec3(d[1].y, d[2]);
  direction.u = dvec3(d[3], d[4].x);
  direction.offset = dvec2(d[4].y, d[5].x);
  return direction;
}

// Returns a . b, added up in the same order on every device, which dot() does not promise.
double dotInOrder(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// Returns floor(log2(x)) for a normal number x > 0.
int exponentOf(double x) { return int((unpackDouble2x32(x).y >> 20) & 0x7FFu) - 1023; }

// Returns a corner's lattice coordinates in units of 1 / fixed_one spacings, rounded to the nearest.
ivec2 snap(dvec3 corner, DirectionData direction, double per_spacing, double fixed_one) {
  precise double x = dotInOrder(corner, direction.x_axis) * per_spacing + direction.offset.x;
  precise double y = dotInOrder(corner, direction.y_axis) * per_spacing + direction.offset.y;
  return ivec2(int(floor(x * fixed_one + 0.5LF)), int(floor(y * fixed_one + 0.5LF)));
}

struct Projection {
  SnappedCorners corners;
  Edge edges[4];
  ProjectedPolygon polygon;
  uint edge_count;
  bool covers_none;  // the polygon covers no lattice point (with scanlines: no column)
};

Projection projectPolygon(uint polygon_index, uint direction_index) {
  DirectionData direction = fetchDirection(direction_index);
  uvec4 corners = texelFetch(polygon_texels, int(3u * polygon_index));  // first, count, id, tie rank
  Projection found;
  found.edge_count = corners.y;

  // Corners are in lattice coordinates, x / h + offset with 1 / h = resolution / 2.
  precise double per_spacing = double(args.resolution) * 0.5LF;
  precise double fixed_one = double(1 << args.fraction_bits);
  double z[4];
  for (uint k = 0u; k < 4u; ++k) {
    dvec3 corner = fetchCorner(corners.x + min(k, corners.y - 1u));
    found.corners.at[k] = snap(corner, direction, per_spacing, fixed_one);
    z[k] = dotInOrder(corner, direction.u);
  }
  ivec2 low = min(min(found.corners.at[0], found.corners.at[1]), min(found.corners.at[2], found.corners.at[3]));
  ivec2 high = max(max(found.corners.at[0], found.corners.at[1]), max(found.corners.at[2], found.corners.at[3]));
  double z_min = min(min(z[0], z[1]), min(z[2], z[3])), z_max = max(max(z[0], z[1]), max(z[2], z[3]));
  int64_t twice_area = int64_t(0);
  for (uint k = 1u; k < 3u; ++k) {
    ivec2 a = found.corners.at[k] - found.corners.at[0], b = found.corners.at[k + 1u] - found.corners.at[0];
    twice_area += int64_t(a.x) * int64_t(b.y) - int64_t(a.y) * int64_t(b.x);
  }
  bool front_up = twice_area > int64_t(0);
  if (!front_up) {  // the corners run clockwise: turn them round
    ivec2 second = found.corners.at[1];
    found.corners.at[1] = found.corners.at[3];
    if (corners.y == 3u) found.corners.at[2] = second;
    found.corners.at[3] = second;
  }
  int column_shift = args.fraction_bits - args.column_bits;
  int first_column = (low.x + (1 << column_shift) - 1) >> column_shift, last_column = high.x >> column_shift;
  found.polygon.box_min =
      max(ivec2(first_column >> args.column_bits, (low.y + (1 << args.fraction_bits) - 1) >> args.fraction_bits),
          ivec2(-args.window));
  found.polygon.box_max =
      min(ivec2(last_column >> args.column_bits, high.y >> args.fraction_bits), ivec2(args.window - 1));
  found.covers_none = twice_area == int64_t(0) || first_column > last_column ||
                      any(greaterThan(found.polygon.box_min, found.polygon.box_max));
  for (uint k = 0u; k < 4u; ++k) found.edges[k] = makeEdge(found.corners, k, args.fraction_bits - args.column_bits);

  // The depth at lattice points is z in the plane's equation, normal . (x, y, z) = plane_offset.
  dvec2 plane_01 = doublesFrom(texelFetch(polygon_texels, int(3u * polygon_index + 1u)));
  dvec2 plane_23 = doublesFrom(texelFetch(polygon_texels, int(3u * polygon_index + 2u)));
  dvec3 normal = dvec3(plane_01, plane_23.x);
  precise double nx = dotInOrder(normal, direction.x_axis);
  precise double ny = dotInOrder(normal, direction.y_axis);
  precise double nz = dotInOrder(normal, direction.u);
  precise double unit = double(1 << kDepthBits);
  precise double steepness = 1.0LF / max(abs(nz), 1e-30LF);
  precise double dx = -nx / (nz * per_spacing) * unit;
  precise double dy = -ny / (nz * per_spacing) * unit;
  precise double d0 = (plane_23.y / nz + 1.0LF) * unit - dx * direction.offset.x - dy * direction.offset.y;
  // Tiles reach up to 18 spacings beyond half the resolution. Depths at their corners, scaled by 2^depth_shift, stay
  // below 2^62.
  double bound = abs(d0) + (abs(dx) + abs(dy)) * double(max(args.resolution, 32)) + 1.0LF;
  int exponent = exponentOf(bound);
  if (abs(nz) > 1e-12LF && exponent < 60) {
    int depth_shift = min(60 - exponent, 30);
    precise double scale = double(1 << depth_shift);
    found.polygon.depth_0 = int64_t(floor(d0 * scale + 0.5LF));
    found.polygon.depth_x_packed = packDepthX(int64_t(floor(dx * scale + 0.5LF)), depth_shift,
                                              front_up);  // below 2^57: resolution is 32 or more in the bound
    found.polygon.depth_y = int64_t(floor(dy * scale + 0.5LF));
  } else {  // the polygon is edge-on: lattice points that it covers by rounding get its mean depth
    found.polygon.depth_0 = int64_t((0.5LF * (z_min + z_max) + 1.0LF) * unit);
    found.polygon.depth_x_packed = packDepthX(int64_t(0), 0, front_up);
    found.polygon.depth_y = int64_t(0);
  }
  // Corners lie within 1e-8 of their plane. With this slack the clamp does not give coplanar polygons different depths.
  double slack = 4.0LF + 2.0LF * min(steepness, 1e6LF);
  found.polygon.depth_min = int(max((z_min + 1.0LF) * unit - slack, 0.0LF));
  found.polygon.depth_max_packed =
      uint(min((z_max + 1.0LF) * unit + slack, 2.0LF * unit)) | placeAtTie(front_up, corners.w) << kTieShift;
  return found;
}

// Appends a polygon to the list that project and bin work off.
//   In: projected_at: the polygon's place in ProjectArgs::projected
void listPolygon(uint projected_at) {
  Status status = Status(args.status);
  uint place = atomicAdd(status.at.listed, 1u);
  Words(args.listed).at[place] = projected_at;
  if (place % gl_WorkGroupSize.x != 0u) return;
  atomicMax(status.at.project_groups.x, place / gl_WorkGroupSize.x + 1u);
  atomicMax(status.at.bin_groups.x, place / gl_WorkGroupSize.x + 1u);
}
