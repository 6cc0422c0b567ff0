// This header includes shaders/shared.h as C++: the structs, constants and rules that host and shaders share.
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

// The shaders read the first five structs as texels of 16 bytes, and expect all structs to have these sizes.
static_assert(sizeof(PolygonData) == 48 && sizeof(ProjectedPolygon) == 48 && sizeof(SnappedCorners) == 32 &&
              sizeof(ActiveTile) == 48 && sizeof(Cover) == 16);
static_assert(sizeof(DirectionData) == 96 && sizeof(CornerData) == 32 && sizeof(Outline) == 40 &&
              sizeof(UnfinishedTile) == 12 && sizeof(BatchStatus) == 136);
static_assert(sizeof(ProjectArgs) <= 128 && sizeof(DrawArgs) <= 128 && sizeof(AccumulateArgs) <= 128);
static_assert(sizeof(BinArgs) <= 128 && sizeof(PeelArgs) <= 128 && sizeof(MeetArgs) <= 128);

// Returns the number of dense counters for this many ids.
inline uint64_t counterCount(uint32_t id_count) { return counterIndex(id_count - 1, id_count + 1, id_count) + 1; }
}  // namespace viewpeel::device_data
