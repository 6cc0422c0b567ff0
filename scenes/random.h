// A SceneRandom draws the random numbers of generated scenes. It uses an engine of the standard library, which gives
// the same numbers on every platform, but none of the library's distributions, which do not.
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <glm/glm.hpp>

namespace viewpeel {

class SceneRandom {
 public:
  explicit SceneRandom(uint64_t seed) : engine_(seed) {}
  double uniform() { return double(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(uniform(0, n)); }
  bool flip() { return below(2) == 1; }
  glm::dvec3 onSphere() {
    const double z = uniform(-1, 1), azimuth_rad = uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z};
  }
  glm::dmat3 rotation() {
    const glm::dvec3 z = onSphere(), x = glm::normalize(glm::cross(z, onSphere()));
    return {x, glm::cross(z, x), z};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace viewpeel
