// The structs and rules that the shaders share, for C++.
#pragma once
#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "facing.h"

namespace viewpeel::device_data {
using uint = std::uint32_t;
using glm::dvec2;
using glm::dvec3;
using glm::ivec2;
using glm::vec2;
#include "../../shaders/shared.h"

static_assert(sizeof(DirectionData) == 88 && sizeof(PolygonData) == 48 && sizeof(ProjectedPolygon) == 96 && sizeof(Edge) == 16);
static_assert(sizeof(ProjectArgs) <= 128 && sizeof(PeelArgs) <= 128 && sizeof(AccumulateArgs) <= 128);
static_assert(sizeof(BinArgs) <= 128 && sizeof(PeelTilesArgs) <= 128);
}  // namespace viewpeel::device_data
