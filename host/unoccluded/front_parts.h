// The part of a polygon in front of a plane has three to five corners. It can be taken as its corners, or as one or two
// shapes.
#pragma once
#include <array>
#include <cstddef>

#include "unoccluded/shared.h"

namespace viewpeel {

// FrontCorners are the corners of the part in front, in order. Less than three of them enclose nothing.
struct FrontCorners {
  struct Corner {
    glm::dvec3 at;  // unit-ball units, as the shape's corners
    double depth;   // over the plane; 0 on it
  };
  std::array<Corner, 5> corners;
  size_t count = 0;
};

// Cuts a polygon along a plane.
//   In: depths: of the polygon's corners over the plane, unit-ball units; rounding: their error; corners nearer to the
//   plane count as on it
FrontCorners frontCornersOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths,
                            double rounding);

// A FrontPart has the corners' depths over the plane, unit-ball units. They are 0 at corners on the plane.
struct FrontPart {
  unoccluded_data::ShapeData shape;
  std::array<double, 4> depths;
};
struct FrontParts {
  std::array<FrontPart, 2> parts;
  size_t count = 0;
};

// Cuts a polygon along a plane, into shapes.    In: as of frontCornersOf    Out: count 0 where nothing is in front
FrontParts frontPartsOf(const unoccluded_data::ShapeData& shape, const std::array<double, 4>& depths, double rounding);

}  // namespace viewpeel
