// In this part of peel.glsl an invocation tests its samples against fragments and polygons, and keeps the nearest
// layers.

// Inserts a layer of sample s, or kNoLayer, among its nearest layers. Where there is no room, the farthest of them is
// left to a later round.
void keepLayer(int s, uint64_t layer) {
  layer = layer > last[s] ? layer : kNoLayer;
  [[unroll]] for (int k = 0; k < kLayersKept; ++k) {
    uint64_t farther = max(nearest[s][k], layer);
    nearest[s][k] = min(nearest[s][k], layer);
    layer = farther;
  }
  lost[s] = min(lost[s], layer);
}

// Keeps fragment k of sample s, where the sample has more than k fragments.
//   In: point: the sample's lattice point, see ProjectArgs::fragments; count: the number of its fragments
void keepFragment(int s, uint k, uint point, uint count) {
  bool has = k < count;
  uint64_t layer = packUint2x32(texelFetch(fragment_texels, int(k * args.point_count + point)).xy);
  if (kMeasuresWork) tally.fragments += has ? fresh >> s & 1u : 0u;
  keepLayer(s, has ? layer : kNoLayer);
}

// Tests sample s against the polygon, and moves the polygon's values on to the next sample.
void takeStep(int s, inout Passing polygon) {
  bool covered =
      kScanlines ? polygon.covered : (polygon.edges.x | polygon.edges.y | polygon.edges.z | polygon.edges.w) >= 0;
  uint64_t depth = uint64_t(clamp(polygon.z >> polygon.z_shift, int64_t(polygon.z_min), int64_t(polygon.z_max)));
  uint64_t layer = (depth << 32 + kTieBits) + polygon.rest;
  if (!kAllCount) {
    if (covered && (polygon.roles & kEmits) != 0u) farthest_emitter[s] = max(farthest_emitter[s], layer);
    if (covered && (polygon.roles & kReceives) != 0u) farthest_receiver[s] = max(farthest_receiver[s], layer);
  }
  if (kMeasuresWork) tally.fragments += covered ? fresh >> s & 1u : 0u;
  keepLayer(s, covered ? layer : kNoLayer);
  polygon.edges += polygon.edges_per_step;
  polygon.z += polygon.z_per_step;
}

// Keeps the fragments at the lattice points of all samples.
void takeFragments(Tile tile, inout bool cut) {
  const uint step = uint(rowsPerStep()) * kTileWidth;
  uint point = tile.first_point + (sample_at.row < int(kTileRows) ? uint(sample_at.row) * kTileWidth : 0u) +
               uint(sample_at.column),
       k = 0u;
  uint counts[kMostSteps];
  [[unroll]] for (uint s = 0u; s < uint(kMostSteps); ++s) counts[s] =
      int(s) < kSteps ? texelFetch(fragment_count_texels, int(point + s * step)).x : 0u;
  do {
#define TAKE(s) keepFragment(s, k, point + uint(s) * step, counts[s])
    EVERY_STEP(TAKE)
#undef TAKE
    ++k;
  } while (k < tile.most_fragments);
  cut = cut || k < tile.most_fragments;
}

// A Loaded is the polygon that an invocation has loaded for all invocations of the subgroup. Numbers of 64 bits are
// held as two words, the lower first.
struct Loaded {
  ivec4 a, b, c;  // with lattice points: changes of its edges per column and row, and values at the tile's corner
  uint columns;   // with scanlines: its span, see spanOf
  uvec4 plane;    // depth before the shift at the tile's corner (with scanlines: in the span's row); depth per column
  uvec2 plane_y;  // depth per row
  // depth_min and depth_max_packed of ProjectedPolygon, Layer::polygon, and remainder << 6 | the low 6 bits of
  // depth_x_packed. With scanlines a column is 2^-kColumnBits spacings, and the remainder is that of the depth per
  // spacing.
  uvec4 bounds;
  uint roles;
};

// Loads entry `entry` of the tile's list or, with scanlines, of `window`. From list_end on it loads a polygon that
// covers nothing.
Loaded loadPolygon(Tile tile, uint entry, uint list_end) {
  bool is_polygon = entry < list_end;
  uint mine = min(entry, max(list_end, 1u) - 1u);
  uvec2 span = kScanlines ? spans[spanIn(window[mine])]
                          : uvec2(list_end == 0u ? 0u : texelFetch(list_texels, int(tile.list_start + mine)).x, 0u);
  uint projected = tile.direction * args.polygon_count + span.x, projected_at = kProjectedTexels * projected;
  uvec4 depth_01 = texelFetch(projected_texels, int(projected_at + 1u));
  uvec4 depth_2 = texelFetch(projected_texels, int(projected_at + 2u));
  Loaded loaded;
  loaded.columns = is_polygon ? span.y : kNoColumns;
  int span_row = kScanlines ? int(firstOf(loaded.columns) / kRowWidth) : 0;
  loaded.a = loaded.b = ivec4(0);
  loaded.c = ivec4(-1);  // covers nothing
  if (!kScanlines) {
    SnappedCorners corners = fetchCorners(projected);
    [[unroll]] for (uint k = 0u; k < 4u; ++k) {
      Edge edge = makeEdge(corners, k, kCutBits);
      loaded.a[k] = is_polygon ? edge.a : 0;
      loaded.b[k] = is_polygon ? edge.b : 0;
      loaded.c[k] = is_polygon ? valueAtCorner(edge, tile.corner) : -1;
    }
  }
  int64_t z_x = depthXOf(longFrom(depth_01.zw)), depth = longFrom(depth_01.xy) + z_x * int64_t(tile.corner.x) +
                                                         longFrom(depth_2.xy) * int64_t(tile.corner.y + span_row);
  // With scanlines the depth grows by z_x x column / 2^kColumnBits, rounded down. The product z_x x column may need
  // more than 64 bits, so z_x is divided first, with remainder.
  int64_t whole = kScanlines ? z_x >> kColumnBits : z_x;
  uint part = kScanlines ? uint(z_x - (whole << kColumnBits)) : 0u;
  loaded.plane = uvec4(unpackUint2x32(uint64_t(depth)), unpackUint2x32(uint64_t(whole)));
  loaded.plane_y = depth_2.xy;
  loaded.bounds = uvec4(depth_2.zw, packLayerPolygon(span.x, frontUpOf(depth_01.z)), part << 6 | depth_01.z & 63u);
  loaded.roles = kAllCount ? 0u : fetchId(span.x) >> kRolesShift;
  return loaded;
}

// Tests all samples of the invocation against the polygon that lane t has loaded.
void takePolygon(Loaded loaded, uint t) {
  uvec4 p = subgroupShuffle(loaded.plane, t), d = subgroupShuffle(loaded.bounds, t);
  Passing polygon;
  polygon.z_shift = int(d.w >> 1 & 31u);
  polygon.z_min = int(d.x);
  polygon.z_max = depthMaxOf(d.y);
  polygon.rest = uint64_t(d.z) + (uint64_t(placeAtTieOf(d.y)) << 32);
  polygon.roles = kAllCount ? 0u : subgroupShuffle(loaded.roles, t);
  int64_t z_at_column = longFrom(p.xy) + longFrom(p.zw) * int64_t(sample_at.column);
  if (kScanlines) {
    uint in_span = subgroupShuffle(loaded.columns, t);
    polygon.covered = sample_at.position - firstOf(in_span) <= in_span >> kPositionBits && in_span != kNoColumns;
    polygon.z = z_at_column + int64_t((d.w >> 6) * uint(sample_at.column) >> kColumnBits);
  } else {
    ivec4 per_row = subgroupShuffle(loaded.b, t);
    polygon.edges =
        subgroupShuffle(loaded.a, t) * sample_at.column + per_row * sample_at.row + subgroupShuffle(loaded.c, t);
    polygon.edges_per_step = per_row * rowsPerStep();
    int64_t z_per_row = longFrom(subgroupShuffle(loaded.plane_y, t));
    polygon.z = z_at_column + z_per_row * int64_t(sample_at.row);
    polygon.z_per_step = z_per_row * int64_t(rowsPerStep());
  }
#define TAKE(s) takeStep(s, polygon)
  EVERY_STEP(TAKE)
#undef TAKE
}
