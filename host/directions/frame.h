// Makes frames about a direction, and says what rounding directions have.
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
constexpr double kAngleMargin = 0x1p-46;  // rad: above the rounding of unit vectors and their products

// A Frame has two axes of unit length.
struct Frame {
  glm::dvec3 x, y;
};

// Returns a frame with x, y, along right-handed.
inline Frame frameAbout(const glm::dvec3& along) {
  const glm::dvec3 helper = std::abs(along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, along));
  return {x, glm::cross(along, x)};
}

// Returns the one front normal of all polygons, or zero.
glm::dvec3 commonFront(const Scene& scene, std::span<const uint32_t> polygons);

}  // namespace viewpeel
