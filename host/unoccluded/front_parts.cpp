#include "unoccluded/front_parts.h"

#include <algorithm>

#include "unoccluded/shapes.h"

namespace viewpeel {

FrontCorners frontCornersOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths,
                            double rounding) {
  // A convex polygon of four corners has at most five in front: three of its own, and two where edges cross the plane.
  FrontCorners front;
  const auto add = [&](const glm::dvec3& at, double depth) {
    if (front.count < front.corners.size()) front.corners[front.count++] = {at, depth};
  };
  for (size_t k = 0; k < 4; ++k) {
    const glm::dvec3 &start = shape.corners[k], &end = shape.corners[(k + 1) % 4];
    if (start == end) continue;  // a triangle has its last corner twice
    const double depth = depths[k], to = depths[(k + 1) % 4];
    if (depth >= -rounding) add(start, std::max(depth, 0.0));
    const bool crosses = (depth > rounding && to < -rounding) || (depth < -rounding && to > rounding);
    if (crosses) add(start + (end - start) * (depth / (depth - to)), 0);
  }
  return front;
}

FrontParts frontPartsOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths, double rounding) {
  const auto [corners, count] = frontCornersOf(shape, depths, rounding);
  FrontParts front;
  const auto add = [&front, &shape, &corners = corners](const std::array<size_t, 4>& of) {
    FrontPart& part = front.parts[front.count];
    part.shape = shape;
    for (size_t k = 0; k < 4; ++k) part.shape.corners[k] = corners[of[k]].at, part.depths[k] = corners[of[k]].depth;
    measureShape(part.shape);
    if (part.shape.area > 0) ++front.count;
  };
  if (count == 3) add({0, 1, 2, 2});
  if (count > 3) add({0, 1, 2, 3});
  if (count > 4) add({0, 3, 4, 4});
  return front;
}

}  // namespace viewpeel
