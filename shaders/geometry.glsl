// Coverage and depth at lattice points, in integers: the same on every device.

// Whether the snapped polygon covers lattice point p. A point on an edge belongs to the polygon that holds it after the
// point has moved by an infinitesimal (-e, e^2): to exactly one of two polygons on either side (the top-left rule).
//   corner_at: index of the polygon's first snapped corner; orientation: +1 where the corners run counter-clockwise, else -1.
// Error: none. With coordinates below 2^kSnapBits each product is below 2^(2 kSnapBits + 2).
bool coversPoint(Snapped snapped, uint corner_at, uint corner_count, int orientation, ivec2 p, int fraction_bits) {
  ivec2 point = p << fraction_bits;
  ivec2 from = snapped.at[corner_at + corner_count - 1u];
  for (uint k = 0u; k < corner_count; ++k) {
    ivec2 to = snapped.at[corner_at + k];
    ivec2 edge = (to - from) * orientation;
    ivec2 away = point - from;
    int64_t side = int64_t(edge.x) * int64_t(away.y) - int64_t(edge.y) * int64_t(away.x);
    bool owns_edge = edge.y > 0 || (edge.y == 0 && edge.x > 0);
    if (edge != ivec2(0) && (side < 0 || (side == 0 && !owns_edge))) return false;
    from = to;
  }
  return true;
}

// The order of a polygon along the line through lattice point p (Layer.key).
uint layerKey(ProjectedPolygon polygon, ivec2 p) {
  int64_t depth = (polygon.depth_0 + polygon.depth_x * int64_t(p.x) + polygon.depth_y * int64_t(p.y)) >> polygon.depth_shift;
  depth = clamp(depth, int64_t(polygon.depth_min), int64_t(polygon.depth_max));
  return 2u * uint(depth) + (1u - polygon.front_up);
}
