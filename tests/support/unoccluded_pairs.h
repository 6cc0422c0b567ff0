// Tests of unoccluded form factors share these scenes of many pairs. They run on the device and on the processor.
#pragma once
#include "scene/group_planes.h"
#include "unoccluded/unoccluded.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/rectangles.h"
#include "tests/support/reference_shapes.h"
#include "tests/support/test_device.h"

namespace viewpeel {

using reference::test::areaOf;
using reference::test::boxFaces;
using reference::test::Corners;
using reference::test::flipped;
using reference::test::moved;
using reference::test::Random;
using reference::test::rectangle;

inline constexpr double kPi = std::numbers::pi;

struct CornerPair {
  Corners a, b;
};

// Returns a scene whose polygons 2k and 2k + 1 are pair k, built as a scene of its own. Polygons of different pairs may
// cross or coincide, for no pair depends on another.
inline Scene sceneOf(const std::vector<CornerPair>& pairs, const SceneOptions& options = {}) {
  Scene all;
  all.file = "pairs";
  all.surfaces = {{"all", static_cast<uint32_t>(2 * pairs.size())}};
  all.scale = 0;
  for (const CornerPair& pair : pairs)
    for (const Corners& corners : {pair.a, pair.b})
      for (const glm::dvec3& corner : corners) all.scale = std::max(all.scale, glm::length(corner));
  for (const CornerPair& pair : pairs) {
    const Scene one = buildScene({"pair", {"all"}, {{pair.a, 0, 0}, {pair.b, 0, 0}}}, options);
    EXPECT_EQ(one.polygons.size(), 2u);
    const double unit = one.scale / all.scale;
    for (Polygon polygon : one.polygons) {
      const auto first = one.corners.begin() + polygon.first_corner;
      polygon.first_corner = static_cast<uint32_t>(all.corners.size());
      polygon.face = static_cast<uint32_t>(all.faces.size());
      polygon.area *= unit * unit;
      all.faces.push_back({0, polygon.face + 1, polygon.face});
      all.polygons.push_back(polygon);
      std::transform(first, first + polygon.corner_count, std::back_inserter(all.corners),
                     [&](const glm::dvec3& corner) { return one.centre / all.scale + unit * corner; });
    }
  }
  groupPlanes(all);
  return all;
}

inline Corners cornersOf(const Scene& scene, uint32_t polygon) {
  const Polygon& p = scene.polygons[polygon];
  return {scene.corners.begin() + p.first_corner, scene.corners.begin() + p.first_corner + p.corner_count};
}

// Returns the form factor from the smaller polygon.
inline double largerFactor(const Scene& scene, uint32_t i, uint32_t j, double exchange_area) {
  return exchange_area / std::min(scene.polygons[i].area, scene.polygons[j].area);
}

inline double allowedError(double form_factor) {
  return std::max(kUnoccludedRelativeError * form_factor, kUnoccludedAbsoluteError);
}

inline testing::AssertionResult isAccurate(double form_factor, double truth, double truth_error) {
  if (std::abs(form_factor - truth) <= allowedError(truth) + truth_error) return testing::AssertionSuccess();
  return testing::AssertionFailure() << fmt::format("{} is off {} by {}, allowed {}", form_factor, truth,
                                                    form_factor - truth, allowedError(truth) + truth_error);
}

inline bool on_host = false;  // true while a test runs on the processor

inline UnoccludedExchange makeExchange(const Scene& scene, const UnoccludedOptions& options = {}) {
  return on_host ? UnoccludedExchange(scene, options) : UnoccludedExchange(testDevice(), scene, options);
}

class Unoccluded : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override { on_host = GetParam(); }
};

struct Outcome {
  std::vector<double> factors;  // form factors from the smaller polygon of each pair
  UnoccludedWork work;
};

// Computes all pairs in both orders. Expects equal bits, and that all pairs reach the accuracy.
inline Outcome computeBothWays(const Scene& scene, const std::string& what) {
  UnoccludedExchange exchange = makeExchange(scene);
  std::vector<SidePair> pairs, reversed;
  for (uint32_t k = 0; k + 1 < scene.polygons.size(); k += 2) pairs.push_back({frontSide(k), frontSide(k + 1)});
  for (const SidePair& pair : pairs) reversed.push_back({pair.j, pair.i});
  std::vector<double> areas(pairs.size()), areas_reversed(pairs.size());
  for (const UnreachedPair& one : exchange.compute(pairs, areas))
    ADD_FAILURE() << what << ": pair " << one.pair << ", area " << areas[one.pair] << ", is only good to " << one.error;
  exchange.compute(reversed, areas_reversed);
  EXPECT_EQ(areas, areas_reversed) << what;
  Outcome outcome{{}, exchange.work()};
  for (size_t k = 0; k < pairs.size(); ++k)
    outcome.factors.push_back(largerFactor(scene, pairs[k].i / 2, pairs[k].j / 2, areas[k]));
  return outcome;
}

// Returns two triangles or quadrilaterals. The first has size 1; the second is smaller by a factor up to `ratio`. Their
// distance is 0.3 to `most`, log-uniform.
inline CornerPair randomPair(Random& random, double most, double ratio) {
  const glm::dvec3 towards = random.direction();
  const auto facing = [&random](glm::dvec3 d) { return glm::normalize(d + 0.9 * random.direction()); };
  const double size = std::exp(random.uniform(0, std::log(ratio))),
               distance = std::exp(random.uniform(std::log(0.3), std::log(most)));
  const Corners a = random.convexPolygon(glm::dvec3(0), facing(towards), 3 + (int)random.uniform(0, 2));
  const Corners b = moved(random.convexPolygon(glm::dvec3(0), facing(-towards), 3 + (int)random.uniform(0, 2)),
                          1 / size, distance * towards);
  return {a, b};
}

}  // namespace viewpeel
