#include "directions/sampler.h"

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace viewpeel {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

class Random {
 public:
  Random(uint64_t seed, uint64_t replicate) {
    std::seed_seq words{uint32_t(seed), uint32_t(seed >> 32), uint32_t(replicate), uint32_t(replicate >> 32)};
    engine_.seed(words);
  }
  // Uniform in [0, 1), the same on every platform.
  double uniform() { return double(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

// A rotation uniform over SO(3), from a uniform unit quaternion (Shoemake 1992).
glm::dmat3 randomRotation(Random& random) {
  const double a = random.uniform(), b = kTwoPi * random.uniform(), c = kTwoPi * random.uniform();
  const double x = std::sqrt(1 - a) * std::sin(b), y = std::sqrt(1 - a) * std::cos(b);
  const double z = std::sqrt(a) * std::sin(c), w = std::sqrt(a) * std::cos(c);
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
          2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
          2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
}

glm::dvec3 fromHeightAndAzimuth(double z, double azimuth_rad) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z};
}

Direction directionAlong(const glm::dvec3& along, Random& random) {
  Direction direction;
  direction.u = glm::normalize(along);
  const glm::dvec3 helper = std::abs(direction.u.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(helper, direction.u)), b = glm::cross(direction.u, a);
  const double turn_rad = kTwoPi * random.uniform();
  direction.x_axis = std::cos(turn_rad) * a + std::sin(turn_rad) * b;
  direction.y_axis = glm::cross(direction.u, direction.x_axis);
  direction.offset.x = random.uniform();
  direction.offset.y = random.uniform();
  return direction;
}

}  // namespace

std::vector<Direction> sampleDirections(Sampler sampler, uint32_t count, uint64_t seed, uint64_t replicate) {
  Random random(seed, replicate);
  std::vector<Direction> directions;
  directions.reserve(count);
  if (sampler == Sampler::fibonacci) {
    const double golden_angle_rad = std::numbers::pi * (3 - std::sqrt(5.0));
    const glm::dmat3 rotation = randomRotation(random);
    for (uint32_t k = 0; k < count; ++k)
      directions.push_back(directionAlong(rotation * fromHeightAndAzimuth(1 - (2.0 * k + 1) / count, golden_angle_rad * k), random));
  } else {
    for (uint32_t k = 0; k < count; ++k) {
      const double z = 2 * random.uniform() - 1;
      directions.push_back(directionAlong(fromHeightAndAzimuth(z, kTwoPi * random.uniform()), random));
    }
  }
  return directions;
}

std::vector<Direction> sampleLattices(const glm::dvec3& u, uint32_t count, uint64_t seed) {
  Random random(seed, 0);
  std::vector<Direction> directions;
  for (uint32_t k = 0; k < count; ++k) directions.push_back(directionAlong(u, random));
  return directions;
}

}  // namespace viewpeel
