// The structs that the closed forms' shaders share, for C++.
#pragma once
#include <cstdint>

#include <glm/vec3.hpp>

namespace viewpeel::closed_form_data {
using uint = std::uint32_t;
using glm::dvec3;
#include "../../shaders/unoccluded/unoccluded.h"

static_assert(sizeof(ShapeData) == 192 && sizeof(WorkList) == kWorkListBytes && sizeof(EdgeData) == 48);
static_assert(sizeof(ClassifyArgs) <= 128 && sizeof(FarArgs) <= 128 && sizeof(EdgesArgs) <= 128 &&
              sizeof(LineArgs) <= 128 && sizeof(SumArgs) <= 128);
}  // namespace viewpeel::closed_form_data
