// Coverage and depth at lattice points, in integers: the same on every device.

// Whether lattice point p lies on the polygon's side of an edge whose columns are the lattice's own.
bool isInside(Edge edge, ivec2 p) {
  return int64_t(edge.a) * int64_t(p.x) + int64_t(edge.b) * int64_t(p.y) + edge.c >= int64_t(0);
}

// The edge between two snapped corners of a polygon whose corners run counter-clockwise (orientation +1) or clockwise (-1).
// A point on an edge belongs to the polygon that holds it after the point has moved by an infinitesimal (-e, e^2): to exactly one of
// the two on either side (the top-left rule).
// Error: none. Coordinates are below 2^kSnapBits, so c below 2^(2 kSnapBits + 2); an edge of no length lets every point pass.
Edge makeEdge(ivec2 from, ivec2 to, int orientation, int fraction_bits, int column_bits) {
  ivec2 along = (to - from) * orientation;
  Edge edge;
  edge.a = -along.y;
  edge.b = along.x;
  bool owns_points = along.y > 0 || (along.y == 0 && along.x >= 0);
  int64_t c = -(int64_t(edge.a) * int64_t(from.x) + int64_t(edge.b) * int64_t(from.y)) - (owns_points ? int64_t(0) : int64_t(1));
  // Rounds down, which is exact: at columns in units of 2^-column_bits the rest of the sum is a multiple of what is cut off.
  edge.c = c >> (fraction_bits - column_bits);
  return edge;
}

// The order of a polygon along the line through lattice point p (Layer.key).
uint layerKey(ProjectedPolygon polygon, ivec2 p) {
  int64_t depth = (polygon.depth_0 + polygon.depth_x * int64_t(p.x) + polygon.depth_y * int64_t(p.y)) >> polygon.depth_shift;
  depth = clamp(depth, int64_t(polygon.depth_min), int64_t(polygon.depth_max));
  return 2u * uint(depth) + (1u - polygon.front_up);
}
