// The kernels of unoccluded form factors share these buffers and functions. The functions load a pair, with the side of
// each polygon that takes part, and measure how far points are above a polygon's plane.
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_control_flow_attributes : require
#include "unoccluded.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SidePairs { SidePairData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Doubles { double at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Edges { EdgeData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LineValues { LineValue at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Unreached { UnreachedData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Status { UnoccludedStatus at; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Work { WorkList at; };

const double kPi = 3.14159265358979323846LF;

// Sides are the two sides of a pair, the lower number first, so that (i, j) and (j, i) have the same result. Here
// ShapeData::plane and tie_rank are of the side, which may be a polygon's back.
struct Sides {
  ShapeData a, b;
  dvec3 normal_a, normal_b;  // unit normals of the sides
  bool is_flipped;           // exactly one of the sides is a back
  bool are_one;              // both sides are of the same polygon
};

// The texels are ShapeData[], in line.comp the points of line rules. Software devices fetch texels faster than they
// load words.
layout(binding = 0) uniform usamplerBuffer texels;

dvec2 fetchDoubles(uint texel) {
  uvec4 bits = texelFetch(texels, int(texel));
  return dvec2(packDouble2x32(bits.xy), packDouble2x32(bits.zw));
}

ShapeData fetchShape(uint index) {
  dvec2 d[kShapeTexels - 1u];
  uint first = index * kShapeTexels;
  [[unroll]] for (uint k = 0u; k < kShapeTexels - 1u; ++k) d[k] = fetchDoubles(first + k);
  ShapeData shape;
  shape.corners = dvec3[](dvec3(d[0], d[1].x), dvec3(d[1].y, d[2]), dvec3(d[3], d[4].x), dvec3(d[4].y, d[5]));
  shape.normal = dvec3(d[6], d[7].x);
  shape.density = d[7].y;
  shape.density_u = d[8].x;
  shape.density_v = d[8].y;
  shape.reach = d[9].x;
  shape.radius = d[9].y;
  shape.skew = d[10].x;
  shape.tilt = d[10].y;
  uvec4 last = texelFetch(texels, int(first + kShapeTexels - 1u));
  shape.area = packDouble2x32(last.xy);
  shape.plane = last.z;
  shape.tie_rank = last.w;
  return shape;
}

Sides loadSides(uint64_t pairs, uint pair) {
  SidePairData requested = SidePairs(pairs).at[pair];
  uint first = min(requested.i, requested.j), second = max(requested.i, requested.j);
  Sides sides;
  sides.a = fetchShape(first >> 1);
  sides.b = fetchShape(second >> 1);
  sides.a.plane ^= first & 1u;
  sides.b.plane ^= second & 1u;
  if ((first & 1u) != 0u) sides.a.tie_rank = kLastTieRank - sides.a.tie_rank;
  if ((second & 1u) != 0u) sides.b.tie_rank = kLastTieRank - sides.b.tie_rank;
  sides.normal_a = (first & 1u) == 0u ? sides.a.normal : -sides.a.normal;
  sides.normal_b = (second & 1u) == 0u ? sides.b.normal : -sides.b.normal;
  sides.is_flipped = ((first ^ second) & 1u) != 0u;
  sides.are_one = (first >> 1) == (second >> 1);
  return sides;
}

dvec3 meanCorner(ShapeData shape) {
  return 0.25LF * ((shape.corners[0] + shape.corners[1]) + (shape.corners[2] + shape.corners[3]));
}

// Returns the depths of the four corners of `shape` over the plane of `plane`.
//   In: normal: the unit normal of the side that spans the plane
dvec4 depthsOf(ShapeData shape, ShapeData plane, dvec3 normal) {
  dvec4 depths;
  [[unroll]] for (int k = 0; k < 4; ++k) depths[k] = dot(normal, shape.corners[k] - plane.corners[0]);
  return depths;
}

// Returns how far a depth over the plane of a shape may be off, because the shape's corners are rounded.
//   In: distance: from the shape's middle
double depthRounding(ShapeData plane, double distance) { return kFrontRounding + plane.tilt * distance; }

// Reserves the next place of a list, which the caller fills, and returns it. Counts the workgroups that the list needs.
uint append(Work work) {
  uint at = atomicAdd(work.at.count, 1u);
  if (at % kUnoccludedGroupSize == 0u) atomicAdd(work.at.groups_x, 1u);
  return at;
}

double leastOf(dvec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
double greatestOf(dvec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// Returns whether the sides lie in one plane, face to face, as the faces of touching solids do.
bool areTouching(Sides sides) {
  return (sides.a.plane ^ sides.b.plane) == 1u && sides.a.tie_rank + sides.b.tie_rank < kLastTieRank;
}
