#include "directions/random.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace viewpeel {

Direction directionAlong(const glm::dvec3& along, Random& random) {
  Direction direction;
  direction.u = glm::normalize(along);
  const glm::dvec3 helper = std::abs(direction.u.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(helper, direction.u)), b = glm::cross(direction.u, a);
  const double turn_rad = 2 * std::numbers::pi * random.uniform();
  direction.x_axis = std::cos(turn_rad) * a + std::sin(turn_rad) * b;
  direction.y_axis = glm::cross(direction.u, direction.x_axis);
  direction.offset.x = random.uniform();
  direction.offset.y = random.uniform();
  return direction;
}

}  // namespace viewpeel
