// Regions and samplers of directions share these frames and bounds on rounding.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

constexpr double kPi = std::numbers::pi;
constexpr double kUnitRounding = std::numeric_limits<double>::epsilon();
constexpr double kAngleMargin = 0x1p-46;  // rad; larger than the rounding of unit vectors and of their products

// A Frame has two axes orthogonal to a direction, of unit length.
struct Frame {
  glm::dvec3 x, y;
};

// Returns a frame such that (x, y, along) is orthonormal and right-handed.    In: along: a unit vector
inline Frame frameAbout(const glm::dvec3& along) {
  const glm::dvec3 helper = std::abs(along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, along));
  return {x, glm::cross(along, x)};
}

// Returns the unit normal of the fronts of polygons if all have the same, else the zero vector.
glm::dvec3 commonFront(const Scene& scene, std::span<const uint32_t> polygons);

}  // namespace viewpeel
