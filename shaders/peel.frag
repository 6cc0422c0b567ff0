#version 460
// One fragment is one polygon at one lattice point. It survives where the polygon covers the point and lies strictly
// behind the previous layer. The depth test then keeps the nearest polygon. Of polygons with equal keys it keeps the
// one with the lowest index, because polygons are drawn in the order of their indices.
#extension GL_GOOGLE_include_directive : require
#define SHARED_FUNCTION
#include "common.glsl"
#include "geometry.glsl"

layout(push_constant, scalar) uniform Args { DrawArgs args; };
layout(location = 0) flat in uint instance;
layout(location = 0) out uvec2 layer;

void main() {
  uint direction_index = instance / args.polygon_count;
  uint polygon_index = instance - direction_index * args.polygon_count;
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 cell = ivec2(direction_index % args.cells_per_row, direction_index / args.cells_per_row) * int(args.cell_size);
  ivec2 p = pixel - cell - int(args.cell_size) / 2;

  ProjectedPolygon polygon = Projected(args.projected).at[instance];
  uint key = layerKey(polygon, p), packed = packLayerPolygon(polygon_index, frontUpOf(uint(polygon.depth_x_packed)));
  Layer previous = Layers(args.previous).at[uint(pixel.y) * args.image_width + uint(pixel.x)];
  if (key < previous.key || (key == previous.key && packed <= previous.polygon)) discard;

  SnappedCorners corners = Snapped(args.snapped_corners).at[instance];
  for (uint k = 0u; k < 4u; ++k)
    if (!isInside(makeEdge(corners, k, args.fraction_bits), p)) discard;
  layer = uvec2(key, packed);
  // Bit patterns of positive floats are in the order of their values, so a 32-bit depth buffer compares keys exactly.
  // There are fewer than 2^30 such patterns below 1, which leaves one bit for the place at ties. This bit tells place 3
  // from place 4; the host refuses scenes with other places.
  gl_FragDepth = uintBitsToFloat((key >> kTieBits << 1 | key >> (kTieBits - 1u) & 1u) + 0x00800000u);
}
