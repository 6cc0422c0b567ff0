#version 460
// One invocation projects one polygon along one direction: snaps its corners to the lattice's fixed point and writes its edges, its depth as a
// plane over the lattice and, for drawing, an outline of the lattice points it can cover.
//   In: directions, polygons, corners     Out: edges, projected, outlines
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"

#include "geometry.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Args { ProjectArgs args; };
layout(binding = 0) uniform usamplerBuffer direction_texels;  // DirectionData
layout(binding = 1) uniform usamplerBuffer polygon_texels;    // PolygonData
layout(binding = 2) uniform usamplerBuffer corner_texels;     // CornerData

dvec2 doublesFrom(uvec4 texel) { return dvec2(packDouble2x32(texel.xy), packDouble2x32(texel.zw)); }

dvec3 fetchCorner(uint index) {
  return dvec3(doublesFrom(texelFetch(corner_texels, int(2u * index))), doublesFrom(texelFetch(corner_texels, int(2u * index + 1u))).x);
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

// The same sum in the same order on every device, which dot() does not promise.
double dotInOrder(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// floor(log2(x)) of a normal x > 0.
int exponentOf(double x) { return int((unpackDouble2x32(x).y >> 20) & 0x7FFu) - 1023; }

ivec2 snap(dvec3 corner, DirectionData direction, double per_spacing, double fixed_one) {
  precise double x = dotInOrder(corner, direction.x_axis) * per_spacing + direction.offset.x;
  precise double y = dotInOrder(corner, direction.y_axis) * per_spacing + direction.offset.y;
  return ivec2(int(floor(x * fixed_one + 0.5LF)), int(floor(y * fixed_one + 0.5LF)));
}

// The corner between two edges, moved outward by a little on either side, so that a rasteriser that snaps and rounds as it likes
// finds every lattice point of the polygon. False where the corner is too sharp for that.
bool widenCorner(Edge before, Edge after, vec2 corner, out vec2 widened) {
  const float kMargin = 1.0 / 16.0;  // of a spacing; rasterisers snap to 1/16 or finer
  vec2 n1 = -vec2(before.a, before.b), n2 = -vec2(after.a, after.b);
  float l1 = length(n1), l2 = length(n2);
  widened = corner;
  if (l1 == 0.0 || l2 == 0.0) return false;
  n1 /= l1;
  n2 /= l2;
  float both = 1.0 + dot(n1, n2);
  widened += kMargin / both * (n1 + n2);
  return both > 0.02;  // moved by at most kMargin sqrt(2 / 0.02) = 0.625
}

void main() {
  uint polygon_index = gl_GlobalInvocationID.x;
  uint direction_index = gl_WorkGroupID.y;
  if (polygon_index >= args.polygon_count || direction_index >= args.direction_count) return;
  DirectionData direction = fetchDirection(direction_index);
  uvec2 corners = texelFetch(polygon_texels, int(3u * polygon_index)).xy;  // first, count
  uint edge_at = direction_index * args.corner_count + corners.x;
  uint projected_at = direction_index * args.polygon_count + polygon_index;

  // Corners in lattice coordinates, x / h + offset with 1 / h = resolution / 2.
  precise double per_spacing = double(args.resolution) * 0.5LF;
  precise double fixed_one = double(1 << args.fraction_bits);
  ivec2 snapped[4];  // a triangle's last corner twice
  double z[4];
  for (uint k = 0u; k < 4u; ++k) {
    dvec3 corner = fetchCorner(corners.x + min(k, corners.y - 1u));
    snapped[k] = snap(corner, direction, per_spacing, fixed_one);
    z[k] = dotInOrder(corner, direction.u);
  }
  ivec2 low = min(min(snapped[0], snapped[1]), min(snapped[2], snapped[3])), high = max(max(snapped[0], snapped[1]), max(snapped[2], snapped[3]));
  double z_min = min(min(z[0], z[1]), min(z[2], z[3])), z_max = max(max(z[0], z[1]), max(z[2], z[3]));
  int64_t twice_area = int64_t(0);
  for (uint k = 1u; k < 3u; ++k) {
    ivec2 a = snapped[k] - snapped[0], b = snapped[k + 1u] - snapped[0];
    twice_area += int64_t(a.x) * int64_t(b.y) - int64_t(a.y) * int64_t(b.x);
  }
  int orientation = twice_area > int64_t(0) ? 1 : -1;

  ProjectedPolygon projected;
  projected.front_up = twice_area > int64_t(0) ? 1u : 0u;
  int column_shift = args.fraction_bits - args.column_bits;
  int first_column = (low.x + (1 << column_shift) - 1) >> column_shift, last_column = high.x >> column_shift;
  projected.box_min = max(ivec2(first_column >> args.column_bits, (low.y + (1 << args.fraction_bits) - 1) >> args.fraction_bits), ivec2(-args.window));
  projected.box_max = min(ivec2(last_column >> args.column_bits, high.y >> args.fraction_bits), ivec2(args.window - 1));
  // Many polygons of a fine mesh lie between lattice points, or beside a window: nothing more is written of them.
  bool covers_none = twice_area == int64_t(0) || first_column > last_column || any(greaterThan(projected.box_min, projected.box_max));
  if (covers_none) {
    projected.box_min = ivec2(1);
    projected.box_max = ivec2(0);
  }
  Edge edges[4];
  for (uint k = 0u; k < 4u; ++k) {
    edges[k] = makeEdge(snapped[k], snapped[k + 1u < corners.y ? k + 1u : 0u], orientation, args.fraction_bits, args.column_bits);
    if (!covers_none && k < corners.y) {
      Longs(args.edges).at[2u * (edge_at + k)] = packUint2x32(uvec2(edges[k].a, edges[k].b));
      Longs(args.edges).at[2u * (edge_at + k) + 1u] = uint64_t(edges[k].c);
    }
  }
  if (args.outlines != uint64_t(0)) {
    Outline outline;
    outline.blocks = uint64_t(0);
    for (int k = 0; k < 4; ++k) outline.strip[k] = vec2(0);
    if (!covers_none) {
      for (int k = 0; k < 4; ++k)
        outline.strip[k] = vec2((k & 1) != 0 ? projected.box_max.x : projected.box_min.x, (k & 2) != 0 ? projected.box_max.y : projected.box_min.y) +
                           vec2((k & 1) != 0 ? 0.5 : -0.5, (k & 2) != 0 ? 0.5 : -0.5);
      uvec2 low_block = uvec2(projected.box_min + int(args.cell_size) / 2), high_block = uvec2(projected.box_max + int(args.cell_size) / 2);
      uint left = blockAlong(low_block.x, args.cell_size), right = blockAlong(high_block.x, args.cell_size);
      uint bottom = blockAlong(low_block.y, args.cell_size), top = blockAlong(high_block.y, args.cell_size);
      for (uint row = bottom; row <= top; ++row) outline.blocks |= uint64_t((2u << right) - (1u << left)) << (8u * row);
      vec2 widened[4];
      bool usable = true;
      for (uint k = 0u; k < 4u; ++k) {
        uint at = min(k, corners.y - 1u);
        usable = widenCorner(edges[at == 0u ? corners.y - 1u : at - 1u], edges[at], vec2(snapped[at]) / float(fixed_one), widened[k]) && usable;
      }
      if (usable) {  // a strip goes 0, 1, 3, 2
        outline.strip[0] = widened[0];
        outline.strip[1] = widened[1];
        outline.strip[2] = widened[3];
        outline.strip[3] = widened[2];
      }
    }
    Outlines(args.outlines).at[projected_at] = outline;
  }

  // normal . (x, y, z) = plane_offset, solved for z at lattice points.
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
  // Tiles reach up to 18 spacings beyond half the resolution: what is multiplied with their corners stays below 2^62.
  double bound = abs(d0) + (abs(dx) + abs(dy)) * double(max(args.resolution, 32)) + 1.0LF;
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
  Longs words = Longs(args.projected + uint64_t(projected_at) * 64ul);  // as few stores as can be: they are what this pass spends its time with
  words.at[0] = packUint2x32(uvec2(projected.box_min));
  words.at[1] = packUint2x32(uvec2(projected.box_max));
  if (covers_none) return;
  words.at[2] = uint64_t(projected.depth_0);
  words.at[3] = uint64_t(projected.depth_x);
  words.at[4] = uint64_t(projected.depth_y);
  words.at[5] = packUint2x32(uvec2(projected.depth_min, projected.depth_max));
  words.at[6] = packUint2x32(uvec2(projected.depth_shift, projected.front_up));
  words.at[7] = packUint2x32(uvec2(edge_at, corners.y));
}
