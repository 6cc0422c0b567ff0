// What earlier passes wrote, read as texels: several times faster than words on software devices.
layout(binding = 0) uniform usamplerBuffer edge_texels;       // Edge
layout(binding = 1) uniform usamplerBuffer projected_texels;  // ProjectedPolygon
layout(binding = 2) uniform usamplerBuffer polygon_texels;    // PolygonData
layout(binding = 3) uniform usamplerBuffer list_texels;       // polygons of tiles
layout(binding = 4) uniform usamplerBuffer tile_texels;       // ActiveTile

int64_t longFrom(uvec2 words) { return int64_t(packUint2x32(words)); }

Edge fetchEdge(uint index) {
  uvec4 texel = texelFetch(edge_texels, int(index));
  Edge edge;
  edge.a = int(texel.x);
  edge.b = int(texel.y);
  edge.c = longFrom(texel.zw);
  return edge;
}

uint fetchId(uint polygon) { return texelFetch(polygon_texels, int(3u * polygon)).z; }
