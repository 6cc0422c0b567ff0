// splitFace() cuts a face of any shape into convex planar polygons.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace viewpeel {

// A face is planar if its corners lie within this distance of its mean plane, in unit-ball units. Other faces are cut
// into triangles. The distance bounds the error of depths. Rounding to single precision moves a coordinate by up to
// 6e-8.
constexpr double kPlanarTolerance = 1e-7;

// Each piece is a loop of corner indices, counter-clockwise about the face's normal.
using Pieces = std::vector<std::vector<uint32_t>>;

// Returns twice the vector area, by Newell's formula. Its direction is the mean normal.
glm::dvec3 twiceVectorArea(const std::vector<glm::dvec3>& corners);

// Returns a loop without corners that repeat the corner before.
std::vector<glm::dvec3> withoutRepeats(std::vector<glm::dvec3> loop);

// Returns corners in the plane orthogonal to a unit normal, with the first one at the origin. Loops that run
// counter-clockwise about the normal do so in the plane.
std::vector<glm::dvec2> flatten(const std::vector<glm::dvec3>& corners, const glm::dvec3& normal);

// Cuts a simple polygon into convex planar pieces that tile it. A convex planar face is returned whole. It keeps
// corners in the middle of an edge, because neighbours may meet there.
//   In: corners: three or more, with consecutive corners distinct and a vector area that is not zero
//   Out: the pieces; empty pieces where the face crosses itself; nullopt where it has more than kMostCorners corners,
//     or would take more than kMostTests tests
//   Cost: O(m^2) tests for m corners where the face is not convex, O(m^3) at worst; triangulation by ear clipping
//     (Meisters 1975), pieces merged as in Hertel & Mehlhorn 1983, so at most four times the least number.
constexpr size_t kMostCorners = 20'000;
// A test compares a corner with a triangle, or an edge with an edge. This many tests take about 2 s.
constexpr uint64_t kMostTests = 500'000'000;
std::optional<Pieces> splitFace(const std::vector<glm::dvec3>& corners);

}  // namespace viewpeel
