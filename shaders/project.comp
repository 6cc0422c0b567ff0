#version 460
// One invocation projects one polygon along one direction. It writes the snapped corners, the depth as a plane over the
// lattice and, for the graphics engine, an outline of the lattice points that the polygon can cover.
//   In: directions, polygons, corners, listed     Out: snapped corners, projected, outlines, listed
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "projection.glsl"

layout(constant_id = 0) const bool kListed = false;  // takes only the polygons that enter has listed
layout(constant_id = 1) const bool kLists = false;   // lists the polygons that can cover lattice points
layout(constant_id = 2) const bool kDraws = false;   // writes outlines

// Moves the corner between two edges outward, so that both edges move out by kMargin. A rasteriser with other rounding
// rules then still draws every lattice point that the polygon covers.
//   Out: widened: the moved corner; returns false where the corner is too sharp to be moved
bool widenCorner(Edge before, Edge after, vec2 corner, out vec2 widened) {
  const float kMargin = 1.0 / 16.0;  // spacings; rasterisers snap to 1/16 of a pixel or finer
  vec2 n1 = -vec2(before.a, before.b), n2 = -vec2(after.a, after.b);
  float l1 = length(n1), l2 = length(n2);
  widened = corner;
  if (l1 == 0.0 || l2 == 0.0) return false;
  n1 /= l1;
  n2 /= l2;
  float both = 1.0 + dot(n1, n2);
  widened += kMargin / both * (n1 + n2);
  return both > 0.02;  // the corner moves by at most kMargin sqrt(2 / 0.02) = 0.625
}

void main() {
  args = pushed;
  uint polygon_index = gl_GlobalInvocationID.x, direction_index = gl_WorkGroupID.y;
  if (kListed) {
    if (polygon_index >= Status(args.status).at.listed) return;
    uint listed = Words(args.listed).at[polygon_index];
    direction_index = listed / args.polygon_count;
    polygon_index = listed - direction_index * args.polygon_count;
  }
  if (polygon_index >= args.polygon_count || direction_index >= args.direction_count) return;
  uint projected_at = direction_index * args.polygon_count + polygon_index;
  Projection found = projectPolygon(polygon_index, direction_index);
  ProjectedPolygon polygon = found.polygon;
  if (!kDraws && found.covers_none) return;  // no later pass reads the polygon
  if (kLists) listPolygon(projected_at);
  Longs corners = Longs(args.snapped_corners + uint64_t(projected_at) * 32ul);
  for (uint k = 0u; k < 4u; ++k) corners.at[k] = packUint2x32(uvec2(found.corners.at[k]));
  if (kDraws) {
    Outline outline;
    outline.blocks = uint64_t(0);
    for (int k = 0; k < 4; ++k) outline.strip[k] = vec2(0);
    if (!found.covers_none) {
      for (int k = 0; k < 4; ++k)
        outline.strip[k] = vec2((k & 1) != 0 ? polygon.box_max.x : polygon.box_min.x,
                                (k & 2) != 0 ? polygon.box_max.y : polygon.box_min.y) +
                           vec2((k & 1) != 0 ? 0.5 : -0.5, (k & 2) != 0 ? 0.5 : -0.5);
      uvec2 low_block = uvec2(polygon.box_min + int(args.cell_size) / 2),
            high_block = uvec2(polygon.box_max + int(args.cell_size) / 2);
      uint left = blockAlong(low_block.x, args.cell_size), right = blockAlong(high_block.x, args.cell_size);
      uint bottom = blockAlong(low_block.y, args.cell_size), top = blockAlong(high_block.y, args.cell_size);
      for (uint row = bottom; row <= top; ++row) outline.blocks |= uint64_t((2u << right) - (1u << left)) << (8u * row);
      vec2 widened[4];
      bool usable = true;
      for (uint k = 0u; k < 4u; ++k) {
        uint at = min(k, found.edge_count - 1u);
        Edge before = found.edges[at == 0u ? 3u : at - 1u], after = found.edges[at + 1u == found.edge_count ? 3u : at];
        usable = widenCorner(before, after, vec2(found.corners.at[at]) / float(1 << args.fraction_bits), widened[k]) &&
                 usable;
      }
      if (usable) {  // a strip takes the corners of a polygon in the order 0, 1, 3, 2
        outline.strip[0] = widened[0];
        outline.strip[1] = widened[1];
        outline.strip[2] = widened[3];
        outline.strip[3] = widened[2];
      }
    }
    Outlines(args.outlines).at[projected_at] = outline;
  }

  // The polygon is stored in six words, for storing takes most of this pass's time.
  Longs words = Longs(args.projected + uint64_t(projected_at) * 48ul);
  words.at[0] = packUint2x32(uvec2(polygon.box_min));
  words.at[1] = packUint2x32(uvec2(polygon.box_max));
  words.at[2] = uint64_t(polygon.depth_0);
  words.at[3] = uint64_t(polygon.depth_x_packed);
  words.at[4] = uint64_t(polygon.depth_y);
  words.at[5] = packUint2x32(uvec2(polygon.depth_min, polygon.depth_max_packed));
}
