// This header gives C++ the structs and constants that shaders/pair_lines/pair_lines.h writes once for both languages.
#pragma once
#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace viewpeel::pair_lines_data {
using uint = std::uint32_t;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;
#include "../../shaders/pair_lines/pair_lines.h"

static_assert(sizeof(PatchData) == 312 && sizeof(BlockerData) == 296 && sizeof(LineTaskData) == 40 &&
              sizeof(LineEndData) == 148 && sizeof(LinePairData) == 464 && sizeof(ObstacleData) == 152);
static_assert(sizeof(PrepareArgs) <= 128 && sizeof(PlaceArgs) <= 128 && sizeof(DrawLinesArgs) <= 128);
}  // namespace viewpeel::pair_lines_data
