#include "unoccluded/front_parts.h"

#include <algorithm>

#include "unoccluded/shapes.h"

namespace viewpeel {

FrontParts frontPartsOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths, double rounding) {
  // A convex polygon of four corners has at most five in front: three of its own, and two where edges cross the plane.
  struct Corner {
    glm::dvec3 at;
    double depth;
  };
  std::array<Corner, 5> corners;
  size_t count = 0;
  for (size_t k = 0; k < 4 && count < corners.size(); ++k) {
    const glm::dvec3 &start = shape.corners[k], &end = shape.corners[(k + 1) % 4];
    if (start == end) continue;  // a triangle has its last corner twice
    const double depth = depths[k], to = depths[(k + 1) % 4];
    if (depth >= -rounding) corners[count++] = {start, std::max(depth, 0.0)};
    const bool crosses = (depth > rounding && to < -rounding) || (depth < -rounding && to > rounding);
    if (crosses && count < corners.size()) corners[count++] = {start + (end - start) * (depth / (depth - to)), 0};
  }
  FrontParts front;
  const auto add = [&](const std::array<size_t, 4>& of) {
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
