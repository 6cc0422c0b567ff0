// This header includes shaders/unoccluded/unoccluded.h as C++: the structs and constants of unoccluded form factors
// that host and shaders share.
#pragma once
#include <cstdint>

#include <glm/vec3.hpp>

namespace viewpeel::unoccluded_data {
using uint = std::uint32_t;
using glm::dvec3;
#include "../../shaders/unoccluded/unoccluded.h"

static_assert(sizeof(ShapeData) == 192 && sizeof(WorkList) == kWorkListBytes && sizeof(EdgeData) == 48);
static_assert(sizeof(ClassifyArgs) <= 128 && sizeof(FarArgs) <= 128 && sizeof(EdgesArgs) <= 128 &&
              sizeof(LineArgs) <= 128 && sizeof(SumArgs) <= 128);
}  // namespace viewpeel::unoccluded_data
