// Coverage and depth at lattice points are integers: the same on every device.

// An Edge lies over the lattice: a X + b y 2^column_bits + c >= 0 where the point (X / 2^column_bits, y) lies on the
// polygon's side of it.
struct Edge {
  int a, b;
  int64_t c;
};

// The value of an edge at a corner is held within this bound, which leaves room for its changes over a tile: fewer than
// 2^30.
const int kSaturated = 1 << 30;

int valueAtCorner(Edge edge, ivec2 corner) {
  int64_t value = int64_t(edge.a) * int64_t(corner.x) + int64_t(edge.b) * int64_t(corner.y) + edge.c;
  return int(clamp(value, int64_t(-kSaturated), int64_t(kSaturated)));
}

// Returns whether lattice point p lies on the polygon's side of an edge whose columns are the lattice's own.
bool isInside(Edge edge, ivec2 p) {
  return int64_t(edge.a) * int64_t(p.x) + int64_t(edge.b) * int64_t(p.y) + edge.c >= int64_t(0);
}

// Makes edge k of a polygon, from corner k to the next. A point on an edge belongs to one polygon, by the top-left
// rule: the one that holds the point after it has moved by an infinitesimal (-e, e^2). Coordinates are below
// 2^kSnapBits, so c is below 2^(2 kSnapBits + 2). An edge of no length lets every point pass.
//   In: cut_bits: bits of the corners' fixed point that are finer than the edge's columns    Error: none
Edge makeEdge(SnappedCorners corners, uint k, int cut_bits) {
  ivec2 from = corners.at[k], along = corners.at[k + 1u & 3u] - from;
  Edge edge;
  edge.a = -along.y;
  edge.b = along.x;
  bool includes_points = along.y > 0 || (along.y == 0 && along.x >= 0);
  int64_t c = -(int64_t(edge.a) * int64_t(from.x) + int64_t(edge.b) * int64_t(from.y)) -
              (includes_points ? int64_t(0) : int64_t(1));
  // Rounding down is exact here: at columns in units of 2^-column_bits the rest of the sum is a multiple of 2^cut_bits.
  edge.c = c >> cut_bits;
  return edge;
}

// Returns a layer's key. depth: the plane's at a lattice point, see ProjectedPolygon.
uint layerKeyOf(int64_t depth, ProjectedPolygon polygon) {
  uint packed_low = uint(polygon.depth_x_packed);
  uint clamped = uint(clamp(depth >> depthShiftOf(packed_low), int64_t(polygon.depth_min),
                            int64_t(depthMaxOf(polygon.depth_max_packed))));
  return clamped << kTieBits | placeAtTieOf(polygon.depth_max_packed);
}

// Returns the order of a polygon along the line through lattice point p (Layer.key).
uint layerKey(ProjectedPolygon polygon, ivec2 p) {
  return layerKeyOf(polygon.depth_0 + depthXOf(polygon.depth_x_packed) * int64_t(p.x) + polygon.depth_y * int64_t(p.y),
                    polygon);
}

// Returns the least X in [0, width] with |a| X + value >= 0, or width where there is none.
// The quotient is off by less than one: tried and mended in integers.
int firstColumn(int size, int64_t value, double reciprocal, int width) {
  int x = int(clamp(ceil(-double(value) * reciprocal), 0.0LF, double(width)));
  int64_t at = int64_t(size) * int64_t(x) + value;
  if (at < int64_t(0)) return min(x + 1, width);
  return x > 0 && at - int64_t(size) >= int64_t(0) ? x - 1 : x;
}

// Keeps of the columns [low, high) of a row the part on an edge's inner side. value: the edge's at the row's first
// column.
void cutRow(Edge edge, int64_t value, int width, inout int low, inout int high) {
  int size = max(abs(edge.a), 1);
  bool from_left = edge.a > 0;
  // A point lies to the right of an edge that ends the span where |a| X - value - 1 >= 0.
  int x = firstColumn(size, from_left ? value : ~value, 1.0LF / double(size), width);
  if (from_left) low = max(low, x);
  else if (edge.a < 0) high = min(high, x);
  else if (value < int64_t(0)) high = 0;
}

// Returns the least depth that a polygon can have at the lattice points of a tile; depth: its plane's at the tile's
// corner, see ProjectedPolygon.
uint nearestDepth(int64_t depth, int64_t depth_x, int64_t depth_y, int shift, ivec2 range, ivec2 tile_size) {
  int64_t least =
      depth + min(depth_x * int64_t(tile_size.x), int64_t(0)) + min(depth_y * int64_t(tile_size.y), int64_t(0));
  return uint(clamp(least >> shift, int64_t(range.x), int64_t(range.y)));
}

// Returns the greatest depth of the plane over a tile.
uint farthestDepth(int64_t depth, int64_t depth_x, int64_t depth_y, int shift, ivec2 range, ivec2 tile_size) {
  int64_t most =
      depth + max(depth_x * int64_t(tile_size.x), int64_t(0)) + max(depth_y * int64_t(tile_size.y), int64_t(0));
  return uint(clamp(most >> shift, int64_t(range.x), int64_t(range.y)));
}
