// The part of a polygon in front of a plane has three to five corners, and is one or two shapes.
#pragma once
#include <array>
#include <cstddef>

#include "unoccluded/shared.h"

namespace viewpeel {

// A FrontPart has the corners' depths over the plane, unit-ball units. They are 0 at corners on the plane.
struct FrontPart {
  unoccluded_data::ShapeData shape;
  std::array<double, 4> depths;
};
struct FrontParts {
  std::array<FrontPart, 2> parts;
  size_t count = 0;
};

// Cuts a polygon along a plane.
//   In: depths: of the polygon's corners over the plane, unit-ball units; rounding: their error; corners nearer to the
//   plane count as on it
//   Out: count 0 where nothing of the polygon is in front
FrontParts frontPartsOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths, double rounding);

}  // namespace viewpeel
