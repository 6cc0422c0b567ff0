// A face of any shape is cut into convex planar polygons.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace viewpeel {

// A face is planar when its corners lie within this distance of its mean plane, unit-ball units. Others are cut into
// triangles. It bounds the error of depths; a coordinate in single precision is good to 6e-8.
constexpr double kPlanarTolerance = 1e-7;

// Pieces are loops of corner indices, counter-clockwise about the face's normal.
using Pieces = std::vector<std::vector<uint32_t>>;

// Returns twice the vector area (Newell's formula); its direction is the mean normal.
glm::dvec3 twiceVectorArea(const std::vector<glm::dvec3>& corners);

// Cuts a simple polygon into convex planar pieces that tile it. A convex planar face is returned whole, corners in the
// middle of an edge included: neighbours may meet there.
//   In: three or more corners, consecutive ones distinct, vector area not zero    Out: pieces; empty when the face
//   crosses itself; nothing when it has more than kMostCorners, or would take more than kMostTests tests
//   Cost: O(m^2) tests for m corners where the face is not convex, O(m^3) at worst; triangulation by ear clipping
//     (Meisters 1975), pieces merged as in Hertel & Mehlhorn 1983, so at most four times the least number.
constexpr size_t kMostCorners = 20'000;
constexpr uint64_t kMostTests = 500'000'000;  // of a corner against a triangle, or an edge against another: 2 s
std::optional<Pieces> splitFace(const std::vector<glm::dvec3>& corners);

}  // namespace viewpeel
