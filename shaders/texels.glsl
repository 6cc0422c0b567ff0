// The passes over tiles read the results of earlier passes as texels, which software devices fetch several times faster
// than they load words.
#include "geometry.glsl"

layout(binding = 0) uniform usamplerBuffer snapped_corner_texels;  // SnappedCorners
layout(binding = 1) uniform usamplerBuffer projected_texels;       // ProjectedPolygon
layout(binding = 2) uniform usamplerBuffer polygon_texels;         // PolygonData
layout(binding = 3) uniform usamplerBuffer list_texels;            // lists; ListEntry in sort, cover_polygons in meet
layout(binding = 4) uniform usamplerBuffer tile_texels;            // ActiveTile

const uint kTileTexels = 3u;
const uint kProjectedTexels = 3u;

int64_t longFrom(uvec2 words) { return int64_t(packUint2x32(words)); }

// Returns the corners of a polygon in one direction.
//   In: projected: direction * polygon_count + polygon
SnappedCorners fetchCorners(uint projected) {
  ivec4 first = ivec4(texelFetch(snapped_corner_texels, int(2u * projected))),
        second = ivec4(texelFetch(snapped_corner_texels, int(2u * projected + 1u)));
  SnappedCorners corners;
  corners.at[0] = first.xy;
  corners.at[1] = first.zw;
  corners.at[2] = second.xy;
  corners.at[3] = second.zw;
  return corners;
}

uint fetchId(uint polygon) { return texelFetch(polygon_texels, int(3u * polygon)).z; }

// A DepthPlane is the depth of a polygon over one tile, see ProjectedPolygon.
struct DepthPlane {
  int64_t at_corner, per_column, per_row;  // before the shift: at the tile's corner, and its changes
  ivec2 range;                             // depth_min, depth_max
  int shift;                               // depth_shift
  bool front_up;
  uint place_at_tie;
  uint projected;  // direction * polygon_count + polygon
};

DepthPlane fetchDepthPlane(uint projected, ivec2 corner) {
  uint projected_at = kProjectedTexels * projected;
  uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u)),
        depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
  DepthPlane plane;
  plane.per_column = depthXOf(longFrom(depth_01.zw));
  plane.per_row = longFrom(depth_2.xy);
  plane.at_corner = longFrom(depth_01.xy) + plane.per_column * int64_t(corner.x) + plane.per_row * int64_t(corner.y);
  plane.range = ivec2(int(depth_2.z), depthMaxOf(depth_2.w));
  plane.place_at_tie = placeAtTieOf(depth_2.w);
  plane.projected = projected;
  plane.shift = depthShiftOf(depth_01.z);
  plane.front_up = frontUpOf(depth_01.z) != 0u;
  return plane;
}

// Returns whether polygon a comes before polygon b on a line, in the order in which peel has its layers.
//   In: depth_a, depth_b: their depths on the line, see depthAt
bool isBefore(DepthPlane a, uint depth_a, DepthPlane b, uint depth_b) {
  uint key_a = depth_a << kTieBits | a.place_at_tie, key_b = depth_b << kTieBits | b.place_at_tie;
  return key_a < key_b || (key_a == key_b && a.projected < b.projected);
}

// Returns a polygon's depth at a lattice point, given by its column and row in the tile.
uint depthAt(DepthPlane plane, ivec2 in_tile) {
  int64_t depth = plane.at_corner + plane.per_column * int64_t(in_tile.x) + plane.per_row * int64_t(in_tile.y);
  return uint(clamp(depth >> plane.shift, int64_t(plane.range.x), int64_t(plane.range.y)));
}
