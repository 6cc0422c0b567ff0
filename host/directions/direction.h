#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace viewpeel {

// One projection: along u onto the plane of x_axis and y_axis, which carries the lattice.
struct Direction {
  glm::dvec3 x_axis, y_axis, u;  // orthonormal, right-handed
  glm::dvec2 offset;             // of the lattice, in spacings, each in [0, 1)
  uint32_t weight = 1;           // of everything counted along it
};

}  // namespace viewpeel
