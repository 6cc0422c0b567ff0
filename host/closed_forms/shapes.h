#pragma once
#include <vector>

#include "closed_forms/shared.h"
#include "scene/scene.h"

namespace viewpeel {

// The scene's polygons as the closed forms' kernels read them, see ShapeData.
//   In: a scene as buildScene makes it.     Out: a shape a polygon, in order.
//   Error: rounding of double.
//   Throws: nothing.     Cost: O(polygons).     Source: none.
std::vector<closed_form_data::ShapeData> makeShapes(const Scene& scene);

}  // namespace viewpeel
