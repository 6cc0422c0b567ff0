// Tests of reference/ use these shapes and comparators.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <gtest/gtest.h>

namespace viewpeel::reference::test {

using Corners = std::vector<glm::dvec3>;

// Returns the parallelogram with corners origin, origin + u, origin + u + v, origin + v. Its front looks along u x v.
inline Corners rectangle(glm::dvec3 origin, glm::dvec3 u, glm::dvec3 v) {
  return {origin, origin + u, origin + u + v, origin + v};
}

// A unit square on the ground that faces up, and one above it that faces down.
inline const Corners kFloor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                     kCeiling = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});

inline Corners flipped(Corners corners) { return {corners.rbegin(), corners.rend()}; }

inline Corners moved(Corners corners, double scale, glm::dvec3 by) {
  for (glm::dvec3& corner : corners) corner = corner * scale + by;
  return corners;
}

inline double areaOf(const Corners& corners) {
  glm::dvec3 sum(0);
  for (size_t k = 2; k < corners.size(); ++k) sum += glm::cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
  return glm::length(sum) / 2;
}

// Returns the six faces of the box from 0 to size, fronts inwards: x = 0, y = 0, z = 0, then their opposites.
inline std::vector<Corners> boxFaces(glm::dvec3 size) {
  const glm::dvec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z), o(0);
  return {rectangle(o, y, z), rectangle(o, z, x), rectangle(o, x, y),
          rectangle(x, z, y), rectangle(y, x, z), rectangle(z, y, x)};
}

struct Random {
  std::mt19937_64 bits;
  explicit Random(uint64_t seed) : bits(seed) {}

  double uniform(double low = 0, double high = 1) { return low + (high - low) * ((double)(bits() >> 11) * 0x1p-53); }

  glm::dvec3 direction() {
    const double z = uniform(-1, 1), angle_rad = uniform(0, 2 * std::numbers::pi), ring = std::sqrt(1 - z * z);
    return {ring * std::cos(angle_rad), ring * std::sin(angle_rad), z};
  }

  // Returns a convex polygon. Its corners lie on an ellipse with half axes 0.3 to 1, one in each of corner_count equal
  // sectors.
  Corners convexPolygon(glm::dvec3 centre, glm::dvec3 normal, int corner_count) {
    const glm::dvec3 x = glm::normalize(glm::cross(normal, direction())), y = glm::cross(normal, x);
    const double rx = uniform(0.3, 1), ry = uniform(0.3, 1);
    Corners corners;
    for (int k = 0; k < corner_count; ++k) {
      const double angle_rad = 2 * std::numbers::pi * (k + uniform(0.1, 0.9)) / corner_count;
      corners.push_back(centre + rx * std::cos(angle_rad) * x + ry * std::sin(angle_rad) * y);
    }
    return corners;
  }
};

struct Pair {
  Corners a, b;
};

// Returns two polygons of three to seven corners, at most 5 apart. About a third reach behind the plane of the other.
inline Pair randomPair(Random& random) {
  const glm::dvec3 towards = random.direction();
  const auto facing = [&random](glm::dvec3 d) { return glm::normalize(d + 0.8 * random.direction()); };
  const int count_a = 3 + (int)random.uniform(0, 5), count_b = 3 + (int)random.uniform(0, 5);
  Corners a = random.convexPolygon(glm::dvec3(0), facing(towards), count_a);
  return {a, random.convexPolygon(random.uniform(1.2, 5) * towards, facing(-towards), count_b)};
}

// Returns whether the value differs from the truth by at most the bound.
inline testing::AssertionResult isWithin(double value, double truth, double bound) {
  if (std::abs(value - truth) <= bound) return testing::AssertionSuccess();
  return testing::AssertionFailure() << std::scientific << value << " is off " << truth << " by "
                                     << std::abs(value - truth) << " > " << bound;
}

// A normal mean differs by more than 4.5 standard errors once in 147,000 comparisons.
constexpr double kStandardErrors = 4.5;

inline testing::AssertionResult isEstimateOf(double value, double standard_error, double truth,
                                             double truth_error = 0) {
  if (!(standard_error >= 0)) return testing::AssertionFailure() << "standard error " << standard_error;
  return isWithin(value, truth, kStandardErrors * standard_error + truth_error);
}

}  // namespace viewpeel::reference::test
