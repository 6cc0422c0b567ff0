// Unoccluded exchange areas are within the error that HostUnoccluded states. For rectangles this error is rounding in
// double arithmetic alone.
#include "unoccluded/host_unoccluded.h"

#include <cmath>
#include <numbers>
#include <random>

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include <viewpeel/compute.h>

#include "reference/closed_forms/rectangles.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"
#include "unoccluded/front_parts.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
using reference::Interval;

// A RectanglePair has the exact form factor from its first face.
struct RectanglePair {
  InputScene scene;
  double form_factor;
};

RectanglePair parallelPair(Interval x, Interval y, Interval xi, Interval eta, double z) {
  RectanglePair pair{{"parallel", {}, {}}, reference::parallelRectangles(x, y, xi, eta, z)};
  ts::addFace(pair.scene, "a", ts::parallelogram({x.low, y.low, 0}, {x.high - x.low, 0, 0}, {0, y.high - y.low, 0}));
  ts::addFace(pair.scene, "b",
              ts::parallelogram({xi.low, eta.low, z}, {0, eta.high - eta.low, 0}, {xi.high - xi.low, 0, 0}));
  return pair;
}

RectanglePair perpendicularPair(Interval x, Interval y, Interval eta, Interval zeta) {
  RectanglePair pair{{"perpendicular", {}, {}}, reference::perpendicularRectangles(x, y, eta, zeta)};
  ts::addFace(pair.scene, "a", ts::parallelogram({x.low, y.low, 0}, {x.high - x.low, 0, 0}, {0, y.high - y.low, 0}));
  ts::addFace(pair.scene, "b",
              ts::parallelogram({0, eta.low, zeta.low}, {0, eta.high - eta.low, 0}, {0, 0, zeta.high - zeta.low}));
  return pair;
}

std::vector<RectanglePair> rectanglePairs() {
  std::vector<RectanglePair> pairs = {
      parallelPair({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1),        parallelPair({0, 1}, {0, 1}, {0, 1}, {0, 1}, 0.125),
      parallelPair({0, 2}, {0, 1}, {0.5, 1}, {3, 3.25}, 0.5), parallelPair({0, 1}, {0, 1}, {4, 5}, {-3, -2}, 2),
      perpendicularPair({0, 1}, {0, 1}, {0, 1}, {0, 1}),      perpendicularPair({0, 3}, {0, 1}, {0, 1}, {0, 0.25}),
      perpendicularPair({0.25, 1}, {0, 1}, {2, 3}, {0.5, 1}), perpendicularPair({6, 7}, {0, 1}, {0, 1}, {5, 6})};
  std::mt19937_64 random(4);
  const auto intervalFrom = [&](double least) {
    const double low = least + std::uniform_real_distribution(0.0, 2.0)(random);
    return Interval{low, low + std::uniform_real_distribution(0.2, 1.5)(random)};
  };
  for (int k = 0; k < 40; ++k) {
    const double height = std::uniform_real_distribution(0.1, 3.0)(random);
    pairs.push_back(parallelPair(intervalFrom(0), intervalFrom(0), intervalFrom(0), intervalFrom(0), height));
    pairs.push_back(perpendicularPair(intervalFrom(0), intervalFrom(0), intervalFrom(0), intervalFrom(0)));
  }
  return pairs;
}

HostUnoccluded::Found findPair(const InputScene& input, double& area) {
  const Scene scene = buildScene(input);
  UnoccludedWork work;
  area = scene.polygons[0].area;
  return HostUnoccluded(scene, 1).findClosely({frontSide(0), frontSide(1)}, work);
}

// The closed forms' own error: 64 e R^2 / A in long double, R at most 12 and A at least 0.04, and one rounding.
double referenceError(double form_factor) { return 64 * 1.1e-19 * 144 / 0.04 + 2.3e-16 * form_factor; }

TEST(UnoccludedError, OfRectanglesIsThatOfDoubleArithmetic) {
  size_t near = 0;
  for (const RectanglePair& pair : rectanglePairs()) {
    double area = 0;
    const HostUnoccluded::Found found = findPair(pair.scene, area);
    const double f = found.area / area, error = found.error / area;
    EXPECT_LE(std::abs(f - pair.form_factor), error + referenceError(pair.form_factor)) << pair.scene.file;
    if (error > 1e-12) {  // a far pair has the error of its product rule
      EXPECT_LE(error, 1.01 * kUnoccludedRelativeError * f);
      continue;
    }
    ++near;
    // Negative control: a truth that is off by 1e-11 is found out.
    EXPECT_GT(std::abs(f - pair.form_factor - 1e-11), error + referenceError(pair.form_factor));
  }
  EXPECT_GE(near, 20u);
}

// Returns F from a point to a rectangle in a parallel plane at the distance 1, of which one corner is above the point.
double cornerFactor(double a, double b) {
  const double ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
  return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * std::numbers::pi);
}

// Corners of a large polygon are rounded to more than the size of a speck's area. This hardly changes what the two
// exchange, for little of the speck's radiation passes near the large contour.
TEST(UnoccludedError, OfASpeckIsThatOfItsRadiation) {
  for (const double size : {1e-3, 1e-5, 1e-7}) {
    const RectanglePair pair = parallelPair({-size / 2, size / 2}, {-size / 2, size / 2}, {-2, 3}, {-1, 4}, 1);
    // The speck is nearly a point: F at its middle differs from the mean by less than size^2.
    const double truth = cornerFactor(2, 1) + cornerFactor(3, 1) + cornerFactor(2, 4) + cornerFactor(3, 4);
    double area = 0;
    const HostUnoccluded::Found found = findPair(pair.scene, area);
    EXPECT_LE(found.error / area, 1e-6 * truth) << size;
    EXPECT_NEAR(found.area / area, truth, found.error / area + size * size) << size;
  }
}

// The corners of turned rectangles are rounded, so that edges are parallel but for rounding. The stated error still
// holds.
TEST(UnoccludedError, HoldsForTurnedRectangles) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (RectanglePair& pair : rectanglePairs()) {
    const glm::dquat turn = glm::normalize(glm::dquat(normal(random), normal(random), normal(random), normal(random)));
    for (InputFace& face : pair.scene.faces)
      for (glm::dvec3& corner : face.corners) corner = turn * corner;
    double area = 0;
    const HostUnoccluded::Found found = findPair(pair.scene, area);
    // Turning rounds corners once more, with coordinates of up to 8 in a pair of rectangles of 0.2 or more.
    const double turned = 8 * 2.2e-16 * 8 / 0.2;
    EXPECT_LE(std::abs(found.area / area - pair.form_factor),
              found.error / area + turned + referenceError(pair.form_factor))
        << pair.scene.file;
  }
}

// HostUnoccluded and the quadrature rules of the kernels find the same areas, within the errors of both.
TEST(UnoccludedError, RulesAgreeWithClosedForms) {
  for (const InputScene& input : {ts::roomWithTouchingBoxes(), ts::cubeInCube(0.5), ts::triangleSoup(60, 0.6, 6)}) {
    const Scene scene = buildScene(input);
    const HostUnoccluded exchange(scene, 1);
    UnoccludedWork work;
    for (uint32_t i = 0; i < scene.polygons.size(); ++i)
      for (uint32_t j = i + 1; j < scene.polygons.size(); ++j) {
        const SidePair pair{frontSide(i), frontSide(j)};
        const HostUnoccluded::Found by_rules = exchange.find(pair, work), closely = exchange.findClosely(pair, work);
        ASSERT_LE(std::abs(by_rules.area - closely.area), by_rules.error + closely.error) << i << " " << j;
      }
  }
}

// Polygons that reach behind each other's planes are cut there. Contours give the same areas within the errors of both.
TEST(UnoccludedError, CutPolygonsAgreeWithContours) {
  UnoccludedWork work;
  double largest = 0;  // of the differences, in stated errors
  for (const InputScene& input :
       {bench::triangulatedCity(1000).scene, bench::city(1000), ts::triangleSoup(100, 0.2, 6)}) {
    const Scene scene = buildScene(input);
    const HostUnoccluded exchange(scene, 1);
    for (uint32_t i = 0; i < scene.polygons.size(); i += 7)
      for (uint32_t j = 0; j < scene.polygons.size(); ++j) {
        const SidePair pair{frontSide(i), frontSide(j)};
        const uint64_t before = work.cut_pairs;
        const HostUnoccluded::Found closely = exchange.findClosely(pair, work);
        if (work.cut_pairs == before) continue;
        const HostUnoccluded::Found by_rules = exchange.find(pair, work);
        ASSERT_LE(closely.error, kUnoccludedRelativeError * closely.area);
        ASSERT_LE(std::abs(by_rules.area - closely.area), by_rules.error + closely.error) << i << " " << j;
        // The next check needs contours with a much smaller error.
        if (by_rules.error < 0.1 * closely.error)
          largest = std::max(largest, std::abs(by_rules.area - closely.area) / closely.error);
      }
  }
  EXPECT_GT(work.cut_pairs, 5'000u);
  EXPECT_GT(largest, 1e-3);  // the stated error is a bound, but not out of all proportion
}

// The parts of a polygon on both sides of a plane add up to its area, and to its integral of the depth.
TEST(FrontParts, OfBothSidesAddUp) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  size_t fives = 0;
  for (int k = 0; k < 400; ++k) {
    unoccluded_data::ShapeData shape{};
    const glm::dvec3 a(normal(random), normal(random), normal(random)), b(normal(random), normal(random), 0);
    // Convex quadrilaterals, and triangles, whose last corner stands twice.
    shape.corners[0] = glm::dvec3(0), shape.corners[1] = a, shape.corners[3] = b;
    shape.corners[2] = k % 2 ? b : 0.9 * a + 0.8 * b;
    shape.normal = glm::normalize(glm::cross(a, b));
    measureShape(shape);
    const glm::dvec3 across = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const double offset = glm::dot(across, 0.4 * (a + b)) + 0.1 * normal(random);
    std::array<double, 4> depths, heights;
    for (size_t c = 0; c < 4; ++c) depths[c] = glm::dot(across, shape.corners[c]) - offset, heights[c] = -depths[c];
    double area = 0, depth = 0;
    const auto add = [&](const FrontParts& front, double sign) {
      fives += front.count == 2;
      for (size_t m = 0; m < front.count; ++m) {
        const FrontPart& part = front.parts[m];
        area += part.shape.area;
        for (const std::array<size_t, 3>& of : {std::array<size_t, 3>{0, 1, 2}, std::array<size_t, 3>{0, 2, 3}}) {
          const auto& c = part.shape.corners;
          const double triangle = 0.5 * glm::length(glm::cross(c[of[1]] - c[of[0]], c[of[2]] - c[of[0]]));
          depth += sign * triangle * (part.depths[of[0]] + part.depths[of[1]] + part.depths[of[2]]) / 3;
        }
        for (const double part_depth : part.depths) EXPECT_GE(part_depth, 0);
      }
    };
    add(frontPartsOf(shape, depths, 1e-15), 1);
    add(frontPartsOf(shape, heights, 1e-15), -1);
    double whole = 0;
    for (const std::array<size_t, 3>& of : {std::array<size_t, 3>{0, 1, 2}, std::array<size_t, 3>{0, 2, 3}}) {
      const auto& c = shape.corners;
      whole += 0.5 * glm::length(glm::cross(c[of[1]] - c[of[0]], c[of[2]] - c[of[0]])) *
               (depths[of[0]] + depths[of[1]] + depths[of[2]]) / 3;
    }
    // Some 30 roundings of numbers below 30.
    const double rounding = 30 * 30 * 2.2e-16;
    EXPECT_NEAR(area, shape.area, rounding);
    EXPECT_NEAR(depth, whole, rounding);
  }
  EXPECT_GT(fives, 20u);
}

// Every form factor of a cube is exact. Standard errors and intervals say so, by polygon and summed by surface.
TEST(UnoccludedError, ACubeIsExactAndSaysSo) {
  const double facing = reference::parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1), beside = (1 - facing) / 4;
  InputScene quarters{"quarters", {}, {}};
  for (const ts::BoxSide& side : ts::sidesOfBox({0, 0, 0}, {1, 1, 1}, true))
    for (int k = 0; k < 4; ++k)
      ts::addFace(
          quarters, "side " + std::to_string(quarters.faces.size() / 4),
          ts::parallelogram(side.origin + 0.5 * (k % 2) * side.a + 0.5 * (k / 2) * side.b, 0.5 * side.a, 0.5 * side.b));
  for (const std::optional<bool> promise : {std::optional<bool>(), std::optional<bool>(false)})
    for (const InputScene& input : {ts::insideOfCube(), quarters}) {
      const Result result =
          computeFormFactors(buildScene(input), {.by = By::surface, .goal = Tolerance{1e-3}, .promise = promise});
      EXPECT_EQ(result.lines, 0u);
      for (uint32_t i = 0; i < 6; ++i) {
        for (uint32_t j = 0; j < 6; ++j) {
          const double truth = i == j ? 0 : i / 2 == j / 2 ? facing : beside;
          const Measured f = result.form_factors.formFactor(i, j);
          EXPECT_LE(std::abs(f.value - truth), 1e-12);
          EXPECT_LE(f.standard_error, 1e-12);
          EXPECT_LE(std::abs(f.value - truth), f.standard_error + 1e-15);
          if (!result.form_factors.hasIntervals()) continue;
          const viewpeel::Interval interval = result.form_factors.interval(i, j);
          EXPECT_LE(interval.upper - interval.lower, 2e-12);
          EXPECT_LE(interval.lower, truth + 1e-15);
          EXPECT_GE(interval.upper, truth - 1e-15);
        }
        EXPECT_NEAR(result.form_factors.rowSums()[i].value, 1, 1e-12);
      }
    }
}

}  // namespace
}  // namespace viewpeel
