// The expectation over directions drawn for one pair, or for one emitter, is the form factor. Areas along directions
// are exact, so that only the choice of directions errs.
#include "directions/drawn_directions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "tests/support/compare.h"
#include "directions/sampler.h"
#include "scenes/exact_scenes.h"
#include "reference/closed_forms/contour_integral.h"
#include "reference/exact/exact_pair_areas.h"
#include "reference/closed_forms/rectangles.h"
#include "tests/support/reference_shapes.h"
#include "tests/support/direction_pairs.h"

namespace viewpeel {
namespace {

// --- the samplers ----------------------------------------------------------------------------------------------------

double pairArea(const reference::ExactPairAreas& found, const std::vector<bool>& is_a, const std::vector<bool>& is_b) {
  double sum = 0;
  for (const reference::PairArea& area : found.pairs)
    if (area.b < is_b.size()) sum += area.area * ((is_a[area.a] && is_b[area.b]) + (is_b[area.a] && is_a[area.b]));
  return sum;
}

// Returns the form factor of one replicate, between two surfaces of several polygons that do not see themselves.
double formFactorOf(const Scene& scene, const DrawnDirections& drawn, std::span<const uint32_t> a,
                    std::span<const uint32_t> b) {
  if (drawn.directions.empty()) return 0;
  std::vector<bool> is_a(scene.polygons.size()), is_b(scene.polygons.size());
  double area_a = 0, sum = 0;
  for (uint32_t k : a) is_a[k] = true, area_a += scene.polygons[k].area;
  for (uint32_t k : b) is_b[k] = true;
  std::vector<glm::dvec3> directions;
  for (const Direction& direction : drawn.directions) directions.push_back(direction.u);
  const auto found = reference::computeExactPairAreas(scene, directions, {.touching_depth = 1e-6});
  for (size_t k = 0; k < found.size(); ++k) sum += drawn.weights[k] * pairArea(found[k], is_a, is_b);
  return 2 / area_a * drawn.weight_unit * sum / double(drawn.directions.size());
}

DrawnDirections wholeSphere(uint32_t count, uint64_t seed, uint64_t replicate) {
  return {sampleDirections(Sampler::fibonacci, count, seed, replicate), std::vector<uint32_t>(count, 1), 1};
}

template <class Draw>
Measured measure(const Scene& scene, std::span<const uint32_t> a, std::span<const uint32_t> b, uint64_t replicates,
                 Draw draw) {
  double sum = 0, squares = 0;
  for (uint64_t replicate = 0; replicate < replicates; ++replicate) {
    const double value = formFactorOf(scene, draw(replicate), a, b);
    sum += value;
    squares += value * value;
  }
  const double n = double(replicates), mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

Measured measurePair(const Scene& scene, const DirectionRegion& region, uint32_t directions, uint64_t replicates) {
  return measure(scene, std::array{0u}, std::array{1u}, replicates,
                 [&](uint64_t replicate) { return sampleRegion(region, directions, 4, replicate); });
}

// Rounding of corners and of exact areas may add this to a form factor.
constexpr double kAreaRounding = 1e-12;

TEST(PairDirections, MeansAreFormFactors) {
  const uint64_t replicates = 24;
  for (const Case& pair : cases()) {
    if (pair.name == "squares at distance 1e-9") continue;
    for (uint64_t seed : {0, 3}) {
      const PairScene placed = sceneOf(pair, seed);
      double truth = 0;
      try {
        truth = reference::formFactor(pair.a, pair.b);
      } catch (const std::exception&) {
        continue;  // the contour integral cannot compute this pair
      }
      const Measured found = measurePair(placed.scene, regionOf(placed.scene), 16, replicates);
      // Smaller form factors are of far pairs, whose contour integral has a relative error of 1e-10.
      double truth_error = truth < 1e-9 ? 1e-8 * truth : kAreaRounding + reference::kContourError;
      // These polygons are nearly folded flat. Only directions within 1e-6 rad of their planes see less than all, by
      // half, and the sample has none of them.
      if (pair.name == "common edge, 1e-6 rad") truth_error += 1e-8;
      EXPECT_TRUE(isEstimateOf(found, truth, replicates, truth_error)) << pair.name << ", seed " << seed;
    }
  }
}

TEST(PairDirections, MeansAreTheClosedFormsOfRectangles) {
  const uint64_t replicates = 32;
  const auto check = [&](const char* name, double truth) {
    const PairScene placed = sceneOf(*std::ranges::find(cases(), name, &Case::name), 5);
    const DirectionRegion region = regionOf(placed.scene);
    const Measured found = measurePair(placed.scene, region, 64, replicates);
    EXPECT_TRUE(isEstimateOf(found, truth, replicates, kAreaRounding)) << name;
    EXPECT_LT(found.standard_error, 3e-3 * truth) << name;
    EXPECT_FALSE(isEstimateOf(found, truth * 1.03, replicates, kAreaRounding)) << name;
    // Negative control: the region is cut, so that it misses a part of the lines.
    DirectionRegion part = region;
    part.clip(glm::normalize(glm::cross(region.map(0, 0.1), region.map(0.4, 0.5))));
    part.close();
    EXPECT_FALSE(isEstimateOf(measurePair(placed.scene, part, 64, replicates), truth, replicates, kAreaRounding))
        << name;
  };
  const reference::Interval unit{0, 1};
  check("squares at distance 1", reference::parallelRectangles(unit, unit, unit, unit, 1));
  check("squares at distance 10", reference::parallelRectangles(unit, unit, unit, unit, 10));
  check("common edge, 90 degrees", reference::perpendicularRectangles(unit, unit, unit, unit));
  check("part of an edge in common", reference::perpendicularRectangles(unit, unit, {0.3, 1.6}, {0, 0.4}));
}

// Directions from the region of two surfaces and from the whole sphere have the same expectation. Surfaces have one or
// several polygons, and the cube may be between them.
TEST(PairDirections, MeansAgreeWithTheWholeSphere) {
  Random random(2);
  const Scene room = tests::turn(tests::makeCubeInCube(), randomRotation(random));
  const uint64_t replicates = 24;
  const auto check = [&](const std::string& name, std::vector<uint32_t> a, std::vector<uint32_t> b,
                         double largest_share) {
    const DirectionRegion region = findPairRegion(room, a, b);
    EXPECT_LE(region.solidAngle(), largest_share * 2 * kPi + 1e-12) << name;
    const Measured drawn = measure(room, a, b, replicates, [&](uint64_t k) { return sampleRegion(region, 64, 5, k); });
    const Measured all = measure(room, a, b, replicates, [&](uint64_t k) { return wholeSphere(64, 6, k); });
    EXPECT_TRUE(areEstimatesOfTheSame(drawn, all, replicates)) << name;
  };
  // Polygons 0 to 5 of the room are low z, high z, low y, high y, low x, high x. The cube's polygons follow in the same
  // order.
  check("floor and ceiling, the cube between", {0}, {1}, 1);
  check("floor and two walls", {0}, {2, 4}, 1);
  check("ceiling and the cube", {1}, {6, 7, 8, 9, 10, 11}, 0.9);
  check("two walls and the cube's top and one side", {2, 4}, {7, 8}, 1);
  EXPECT_TRUE(findPairRegion(room, std::array{6u}, std::array{7u, 8u, 9u, 10u, 11u}).isEmpty());
}

TEST(PairDirections, LargeSurfacesEnterByTheirBoxes) {
  SceneBuilder builder;
  std::vector<uint32_t> a, b;
  const int side = 20;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double h = 0.4 / side, x = i * h, y = j * h;
      a.push_back(uint32_t(builder.scene.polygons.size()));
      builder.addPolygon("a", rectangle({x, y, -0.5}, {h, 0, 0}, {0, h, 0}));
      b.push_back(uint32_t(builder.scene.polygons.size()));
      builder.addPolygon("b", rectangle({x, y, 0.5}, {0, h, 0}, {h, 0, 0}));
    }
  const DirectionRegion region = findPairRegion(builder.scene, a, b);
  EXPECT_NEAR(region.solidAngle(), 4 * std::asin(0.16 / 1.16), 1e-10);
  const DirectionRegion same = findPairRegion(builder.scene, a, a);  // overlapping boxes need the whole half sphere
  EXPECT_NEAR(same.solidAngle(), 2 * kPi, 1e-12);
}

TEST(PairDirections, TwoSidedPolygonsCountBothSides) {
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const Corners& other : {squareAbove(1), flipped(squareAbove(1)), squareAbove(-1), hinged(1)}) {
    const PairScene placed = sceneOf({"", square, other}, 4);
    const DirectionRegion region = findPairRegion(placed.scene, std::array{0u}, std::array{1u}, true);
    Random random(8);
    std::vector<glm::dvec3> directions;
    for (int k = 0; k < 500; ++k) directions.push_back(random.direction());
    const auto found = reference::computeExactPairAreas(placed.scene, directions, {.two_sided = true});
    for (size_t k = 0; k < directions.size(); ++k)
      if (pairArea(found[k], {true, false}, {false, true}) > 0) {
        EXPECT_TRUE(region.contains(directions[k]) || region.contains(-directions[k]));
      }
  }
}

TEST(DrawnDirections, AreAFunctionOfSeedAndReplicate) {
  const PairScene placed = sceneOf(cases()[0], 1);
  const DirectionRegion region = regionOf(placed.scene);
  const std::array emitter{0u};
  const auto draw = [&](int kind, uint64_t seed, uint64_t replicate) {
    return kind ? sampleEmitter(placed.scene, emitter, 10, seed, replicate) : sampleRegion(region, 10, seed, replicate);
  };
  for (int kind : {0, 1}) {
    EXPECT_EQ(draw(kind, 3, 1).directions[5].u, draw(kind, 3, 1).directions[5].u);
    EXPECT_NE(draw(kind, 3, 1).directions[5].u, draw(kind, 3, 2).directions[5].u);
    EXPECT_NE(draw(kind, 3, 1).directions[5].u, draw(kind, 4, 1).directions[5].u);
    for (const Direction& d : draw(kind, 9, 9).directions) {
      EXPECT_NEAR(glm::length(d.u), 1, 1e-15);
      EXPECT_NEAR(glm::dot(d.u, d.x_axis), 0, 1e-15);
      EXPECT_LT(glm::length(glm::cross(d.x_axis, d.y_axis) - d.u), 2e-15);
      EXPECT_TRUE(d.offset.x >= 0 && d.offset.x < 1 && d.offset.y >= 0 && d.offset.y < 1);
    }
  }
}

// --- the emitter -----------------------------------------------------------------------------------------------------

// The mean of weight x f over a set has the mean of f over the half sphere as its expectation. The tolerance is 5
// standard errors; for 5 means the false-alarm rate is 3e-6.
TEST(EmitterDirections, WeightsHaveTheRightExpectation) {
  const PairScene placed = sceneOf(cases()[0], 2);
  const glm::dvec3 normal = placed.scene.planes[placed.scene.polygons[0].plane].normal;
  const uint64_t replicates = 20000;
  // The means are E[1] = 1, E[cos] = 1/2, E[cos^2] = 1/3, E[u_x^2] = 1/3, and 0 for the rounding of the weight.
  const double expected[5] = {1, 0.5, 1 / 3.0, 1 / 3.0, 0};
  double sum[5] = {}, squares[5] = {};
  for (uint64_t replicate = 0; replicate < replicates; ++replicate) {
    const uint32_t count = 7;
    const DrawnDirections drawn = sampleEmitter(placed.scene, std::array{0u}, count, 77, replicate);
    double means[5] = {};
    for (uint32_t which = 0; which < count; ++which) {
      const glm::dvec3 u = drawn.directions[which].u;
      const double weight = drawn.weights[which] * drawn.weight_unit, cosine = glm::dot(normal, u);
      EXPECT_GE(cosine, -1e-15);
      const double exact = 1 / (2 * (1 - kUniformShare) * cosine + kUniformShare);
      EXPECT_LT(std::abs(weight - exact), drawn.weight_unit * 1.0001);
      const double values[5] = {weight, weight * cosine, weight * cosine * cosine, weight * u.x * u.x,
                                (weight - exact) / drawn.weight_unit};
      for (int k = 0; k < 5; ++k) means[k] += values[k] / count;
    }
    for (int k = 0; k < 5; ++k) sum[k] += means[k], squares[k] += means[k] * means[k];
  }
  for (int k = 0; k < 5; ++k) {
    const double n = double(replicates), mean = sum[k] / n, error = std::sqrt((squares[k] / n - mean * mean) / n);
    EXPECT_NEAR(mean, expected[k], 5 * error) << "moment " << k;
    EXPECT_GT(std::abs(mean - expected[k] - 0.02), 5 * error) << "moment " << k;
  }
}

TEST(EmitterDirections, WeightsAreBounded) {
  const PairScene placed = sceneOf(cases()[0], 2);
  uint32_t least = ~0u, most = 0;
  for (uint64_t replicate = 0; replicate < 20; ++replicate)
    for (uint32_t weight : sampleEmitter(placed.scene, std::array{0u}, 100000, 1, replicate).weights) {
      least = std::min(least, weight);
      most = std::max(most, weight);
    }
  EXPECT_GE(least, 1u << 11);
  EXPECT_LE(most, 1u << 14);
  EXPECT_GT(most, 1u << 13);
}

TEST(EmitterDirections, MeansAreFormFactors) {
  const uint64_t replicates = 32;
  for (const Case& pair : cases()) {
    if (pair.name.starts_with("s") || pair.name.find("1e-") != std::string::npos ||
        pair.name.find("nearly") != std::string::npos)
      continue;
    const PairScene placed = sceneOf(pair, 6);
    const double truth = reference::formFactor(pair.a, pair.b);
    const Measured found = measure(placed.scene, std::array{0u}, std::array{1u}, replicates,
                                   [&](uint64_t k) { return sampleEmitter(placed.scene, std::array{0u}, 64, 3, k); });
    // For smaller form factors so few directions meet the pair that the mean is not near normal.
    if (truth > 0.01) {
      EXPECT_TRUE(isEstimateOf(found, truth, replicates, kAreaRounding + reference::kContourError)) << pair.name;
      EXPECT_FALSE(isEstimateOf(found, truth * 2, replicates)) << pair.name;
    }
  }
}

TEST(EmitterDirections, SeveralNormalsGetTheWholeSphere) {
  const Scene room = tests::makeCubeInCube();
  const DrawnDirections drawn = sampleEmitter(room, std::array{0u, 2u}, 50, 1, 2), all = wholeSphere(50, 1, 2);
  for (int k = 0; k < 50; ++k) EXPECT_EQ(drawn.directions[k].u, all.directions[k].u);
  EXPECT_EQ(drawn.weights, all.weights);
  EXPECT_EQ(drawn.weight_unit, 1);
}

// --- the gain --------------------------------------------------------------------------------------------------------

// This is no test. It prints the rms error of a replicate by directions over the whole sphere and by drawn directions.
// Run it with --gtest_also_run_disabled_tests.
TEST(DrawnDirections, DISABLED_Gain) {
  const uint64_t replicates = 40;
  const auto print = [&](const std::string& name, uint32_t count, const Measured& all, const Measured& drawn) {
    const double to_rms = std::sqrt(double(replicates - 1));
    std::printf("%-40s %5u  F %.6e  sphere %.2e  asked %.2e  ratio %.1f\n", name.c_str(), count, drawn.value,
                all.standard_error * to_rms / drawn.value, drawn.standard_error * to_rms / drawn.value,
                all.standard_error / drawn.standard_error);
  };
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const std::vector<Case> pairs = {
      {"unit squares at 1", square, squareAbove(1)},
      {"unit squares at 3", square, squareAbove(3)},
      {"unit squares at 10", square, squareAbove(10)},
      {"perpendicular, common edge", square, hinged(kPi / 2)},
      {"patches of 0.1 at 10", rectangle({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}), squareAbove(10, 0.1)}};
  for (const Case& pair : pairs) {
    const PairScene placed = sceneOf(pair, 9);
    const DirectionRegion region = regionOf(placed.scene);
    std::printf("%s: solid angle / 2 pi = %.3e\n", pair.name.c_str(), region.solidAngle() / (2 * kPi));
    for (uint32_t count : {100, 400, 1600})
      print(pair.name, count,
            measure(placed.scene, std::array{0u}, std::array{1u}, replicates,
                    [&](uint64_t k) { return wholeSphere(count, 6, k); }),
            measurePair(placed.scene, region, count, replicates));
  }
  SceneBuilder builder;
  builder.addBox("room", glm::dvec3(-0.5), glm::dvec3(0.5), true);
  builder.addPolygon("patch", rectangle({-0.1, -0.1, -0.49}, {0.2, 0, 0}, {0, 0.2, 0}));
  builder.addBox("lamp", {-0.2, -0.15, 0.1}, {0.1, 0.05, 0.2});
  builder.addBox("shelf", {0.1, -0.4, -0.2}, {0.4, 0.4, -0.15});
  Random random(3);
  const Scene scene = tests::turn(builder.scene, randomRotation(random));
  const std::array emitter{6u};
  const std::vector<std::pair<const char*, std::vector<uint32_t>>> receivers = {
      {"patch to ceiling", {1}},
      {"patch to a wall", {2}},
      {"patch to lamp", {7, 8, 9, 10, 11, 12}},
      {"patch to shelf", {13, 14, 15, 16, 17, 18}}};
  for (const auto& [name, receiver] : receivers)
    for (uint32_t count : {100, 400, 1600})
      print(name, count,
            measure(scene, emitter, receiver, replicates, [&](uint64_t k) { return wholeSphere(count, 6, k); }),
            measure(scene, emitter, receiver, replicates,
                    [&](uint64_t k) { return sampleEmitter(scene, emitter, count, 5, k); }));
}

}  // namespace
}  // namespace viewpeel
