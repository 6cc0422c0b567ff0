// These pairs of polygons are hard cases for directions that are drawn for one pair.
#pragma once
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "directions/drawn_directions.h"
#include "scene/interpenetration.h"
#include "scenes/exact_scenes.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {

using reference::test::areaOf;
using reference::test::Corners;
using reference::test::flipped;
using reference::test::Random;
using reference::test::rectangle;
using tests::SceneBuilder;

inline constexpr double kPi = std::numbers::pi;

inline glm::dmat3 randomRotation(Random& random) {
  const glm::dvec3 z = random.direction(), x = glm::normalize(glm::cross(z, random.direction()));
  return {x, glm::cross(z, x), z};
}

struct Case {
  std::string name;
  Corners a, b;
};

inline Corners squareAbove(double z, double side = 1) { return rectangle({0, 0, z}, {0, side, 0}, {side, 0, 0}); }
// Returns a square that shares the edge from (0, 0, 0) to (0, 1, 0) with the unit square. The fronts enclose this
// angle.
inline Corners hinged(double angle_rad) {
  return rectangle({0, 0, 0}, {0, 1, 0}, {std::cos(angle_rad), 0, std::sin(angle_rad)});
}

inline const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    std::vector<Case> list = {
        {"squares at distance 1", square, squareAbove(1)},
        {"squares at distance 10", square, squareAbove(10)},
        {"squares at distance 1e-3", square, squareAbove(1e-3)},
        {"squares at distance 1e-9", square, squareAbove(1e-9)},
        {"common edge, 90 degrees", square, hinged(kPi / 2)},
        {"common edge, 1 degree", square, hinged(kPi / 180)},
        {"common edge, 1e-6 rad", square, hinged(1e-6)},
        {"common edge, 179 degrees", square, hinged(kPi * 179 / 180)},
        {"common edge, nearly coplanar", square, hinged(kPi - 1e-7)},
        {"common corner", square, rectangle({1, 1, 0}, {1, -1, 0}, {0, 0, 1})},
        {"part of an edge in common", square, rectangle({0, 0.3, 0}, {0, 1.3, 0}, {0, 0, 0.4})},
        {"standing on the other", square, rectangle({0.4, 0.2, 0}, {0, 0.5, 0}, {0, 0, 0.7})},
        {"standing across the other's edge", square, rectangle({0.4, 0.5, 0}, {0, 0.9, 0}, {0, 0, 0.7})},
        {"reaching behind", rectangle({0.5, 0, 0}, {2, 0, 0}, {0, 1, 0}),
         rectangle({0, 0, -0.5}, {0.2, 1, 0}, {0.1, 0, 1})},
        {"small and far", rectangle({0, 0, 0}, {1e-6, 0, 0}, {0, 1e-6, 0}),
         rectangle({0.5, 0.1, 1}, {0, 2e-6, 0}, {1e-6, 0, 1e-6})},
        {"small and large", rectangle({0.3, 0.3, 0}, {1e-5, 0, 0}, {0, 1e-5, 0}), squareAbove(0.5)},
        {"slivers", rectangle({0, 0, 0}, {1, 0, 0}, {0, 1e-5, 0}), rectangle({0, 0, 0.3}, {0, 1, 0}, {1e-5, 0, 0})},
        {"triangle and pentagon",
         {{0, 0, 0}, {1, 0.1, 0}, {0.3, 0.8, 0}},
         {{0.2, 0.2, 0.5}, {0, 0.6, 0.7}, {0.3, 0.9, 0.7}, {0.7, 0.8, 0.5}, {0.65, 0.4, 0.4}}}};
    // All corners of the pentagon are moved into one plane.
    for (glm::dvec3& corner : list.back().b) corner.z = 0.6 + 0.2 * corner.x - 0.3 * corner.y;
    Random random(99);
    while (list.size() < 58) {
      auto [a, b] = reference::test::randomPair(random);
      SceneBuilder builder;
      builder.addPolygon("a", reference::test::moved(a, 0.1, glm::dvec3(0)));
      builder.addPolygon("b", reference::test::moved(b, 0.1, glm::dvec3(0)));
      if (!findInterpenetrations(builder.scene).empty()) continue;
      list.push_back({"random pair " + std::to_string(list.size()), a, b});
    }
    return list;
  }();
  return all;
}

struct PairScene {
  Scene scene;
  double scale = 1;  // length in the scene over length in the case
  Corners a, b;      // in units of the scene
};

// Places the case in the unit ball. A seed other than 0 turns it, so that no edge lies along an axis; rounding may then
// open contacts.
inline PairScene sceneOf(const Case& pair, uint64_t seed = 0) {
  glm::dvec3 low(1e9), high(-1e9);
  for (const Corners& corners : {pair.a, pair.b})
    for (const glm::dvec3& corner : corners) low = glm::min(low, corner), high = glm::max(high, corner);
  PairScene result;
  result.scale = 2 / glm::length(high - low) * 0.99;
  Random random(seed);
  const glm::dmat3 turn = seed == 0 ? glm::dmat3(1) : randomRotation(random);
  const auto place = [&](Corners corners) {
    for (glm::dvec3& corner : corners) corner = turn * ((corner - (low + high) / 2.0) * result.scale);
    return corners;
  };
  result.a = place(pair.a);
  result.b = place(pair.b);
  SceneBuilder builder;
  builder.addPolygon("a", result.a);
  builder.addPolygon("b", result.b);
  result.scene = builder.scene;
  return result;
}

inline DirectionRegion regionOf(const Scene& scene) { return findPairRegion(scene, std::array{0u}, std::array{1u}); }

}  // namespace viewpeel
