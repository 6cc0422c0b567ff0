// Coverage and depth at lattice points are computed in integers, so they are the same on every device.

// An Edge is a half-plane over the lattice: its value a X + b y 2^column_bits + c is >= 0 where the point
// (X / 2^column_bits, y) lies on the polygon's side of the edge.
struct Edge {
  int a, b;
  int64_t c;
};

// Values of edges at a tile's corner are clamped to this bound. They change by less than 2^30 over a tile, so they fit
// 32 bits in the whole tile and keep their sign.
const int kSaturated = 1 << 30;

// Returns the clamped value of an edge at the lattice point `corner`, for edges whose columns are lattice columns.
int valueAtCorner(Edge edge, ivec2 corner) {
  int64_t value = int64_t(edge.a) * int64_t(corner.x) + int64_t(edge.b) * int64_t(corner.y) + edge.c;
  return int(clamp(value, int64_t(-kSaturated), int64_t(kSaturated)));
}

// Returns whether lattice point p lies on the polygon's side of an edge, for edges whose columns are lattice columns.
bool isInside(Edge edge, ivec2 p) {
  return int64_t(edge.a) * int64_t(p.x) + int64_t(edge.b) * int64_t(p.y) + edge.c >= int64_t(0);
}

// Makes edge k of a polygon, from corner k to the next corner. By the top-left rule a point on an edge belongs to the
// polygon that holds it after a move by an infinitesimal (-e, e^2). Coordinates are below 2^kSnapBits, so |c| is below
// 2^(2 kSnapBits + 2). Every point lies on the polygon's side of an edge of length 0.
//   In: cut_bits: fraction bits of snapped coordinates less the column bits of the edge    Error: none
Edge makeEdge(SnappedCorners corners, uint k, int cut_bits) {
  ivec2 from = corners.at[k], along = corners.at[k + 1u & 3u] - from;
  Edge edge;
  edge.a = -along.y;
  edge.b = along.x;
  bool includes_points = along.y > 0 || (along.y == 0 && along.x >= 0);
  int64_t c = -(int64_t(edge.a) * int64_t(from.x) + int64_t(edge.b) * int64_t(from.y)) -
              (includes_points ? int64_t(0) : int64_t(1));
  // This shift does not change the sign of an edge's value, for the other terms are multiples of 2^cut_bits.
  edge.c = c >> cut_bits;
  return edge;
}

// Returns Layer::key of a polygon at a lattice point.
//   In: depth: depth_0 + depth_x p.x + depth_y p.y of the ProjectedPolygon at the point p
uint layerKeyOf(int64_t depth, ProjectedPolygon polygon) {
  uint packed_low = uint(polygon.depth_x_packed);
  uint clamped = uint(clamp(depth >> depthShiftOf(packed_low), int64_t(polygon.depth_min),
                            int64_t(depthMaxOf(polygon.depth_max_packed))));
  return clamped << kTieBits | placeAtTieOf(polygon.depth_max_packed);
}

// Returns Layer::key of a polygon on the line through lattice point p.
uint layerKey(ProjectedPolygon polygon, ivec2 p) {
  return layerKeyOf(polygon.depth_0 + depthXOf(polygon.depth_x_packed) * int64_t(p.x) + polygon.depth_y * int64_t(p.y),
                    polygon);
}

// Returns the least X in [0, width] with size X + value >= 0, or width where there is none. The quotient is off by less
// than one; a test in integers corrects it.
//   In: size >= 1; reciprocal = 1 / size
int firstColumn(int size, int64_t value, double reciprocal, int width) {
  int x = int(clamp(ceil(-double(value) * reciprocal), 0.0LF, double(width)));
  int64_t at = int64_t(size) * int64_t(x) + value;
  if (at < int64_t(0)) return min(x + 1, width);
  return x > 0 && at - int64_t(size) >= int64_t(0) ? x - 1 : x;
}

// Narrows the range [low, high) of a row's columns to the columns on the polygon's side of an edge.
//   In: value: the edge's value at the row's first column; width: number of columns in the row
void cutRow(Edge edge, int64_t value, int width, inout int low, inout int high) {
  int size = max(abs(edge.a), 1);
  bool from_left = edge.a > 0;
  // With a < 0 the first column outside is the least X with |a| X - value - 1 >= 0, and -value - 1 is ~value.
  int x = firstColumn(size, from_left ? value : ~value, 1.0LF / double(size), width);
  if (from_left) low = max(low, x);
  else if (edge.a < 0) high = min(high, x);
  else if (value < int64_t(0)) high = 0;
}

// Returns a lower bound of a polygon's depth at the lattice points of a tile, in the units of ProjectedPolygon.
//   In: depth, depth_x, depth_y: its plane before the shift: at the tile's corner, per column, per row; range: the
//     polygon's depth_min and depth_max; tile_size: columns, rows
uint nearestDepth(int64_t depth, int64_t depth_x, int64_t depth_y, int shift, ivec2 range, ivec2 tile_size) {
  int64_t least =
      depth + min(depth_x * int64_t(tile_size.x), int64_t(0)) + min(depth_y * int64_t(tile_size.y), int64_t(0));
  return uint(clamp(least >> shift, int64_t(range.x), int64_t(range.y)));
}

// Returns an upper bound of the same depth, from the same arguments as nearestDepth.
uint farthestDepth(int64_t depth, int64_t depth_x, int64_t depth_y, int shift, ivec2 range, ivec2 tile_size) {
  int64_t most =
      depth + max(depth_x * int64_t(tile_size.x), int64_t(0)) + max(depth_y * int64_t(tile_size.y), int64_t(0));
  return uint(clamp(most >> shift, int64_t(range.x), int64_t(range.y)));
}
