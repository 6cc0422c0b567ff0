// These tests check parts of the rival methods in the bench: sample points, weights of hemicube pixels, and errors of
// matrices.
#include <algorithm>

#include <gtest/gtest.h>

#include "bench/support/exchange_matrix.h"
#include "scenes/generate.h"
#include "bench/rivals/hemicube_weights.h"
#include "bench/support/points.h"

namespace viewpeel::bench {
namespace {

// Of 2^m Sobol' points, scrambled or not, each elementary interval of area 2^-m in dimensions 1 and 2 holds one: they
// are a (0, m, 2)-net. Every dimension by itself has one point in each interval of length 2^-m.
TEST(Points, SobolPointsAreStratified) {
  constexpr uint32_t kBits = 8;
  PointSource source(Points::sobol, 3, 5);
  std::vector<std::array<uint32_t, kDimensions>> points;
  for (uint32_t k = 0; k < 1u << kBits; ++k) points.push_back(source.next());
  for (uint32_t d = 0; d < kDimensions; ++d) {
    std::vector<bool> is_hit(points.size(), false);
    for (const auto& p : points) is_hit[p[d] >> (32 - kBits)] = true;
    EXPECT_EQ(std::count(is_hit.begin(), is_hit.end(), true), 1 << kBits) << "dimension " << d;
  }
  for (uint32_t first_bits = 1; first_bits < kBits; ++first_bits) {
    std::vector<bool> is_hit(points.size(), false);
    for (const auto& p : points)
      is_hit[(p[0] >> (32 - first_bits)) << (kBits - first_bits) | p[1] >> (32 - (kBits - first_bits))] = true;
    EXPECT_EQ(std::count(is_hit.begin(), is_hit.end(), true), 1 << kBits)
        << first_bits << " bits of the first dimension";
  }
}

TEST(Points, ASourceGoesOnWhereAnotherEnds) {
  for (const Points points : {Points::random, Points::sobol}) {
    PointSource whole(points, 3, 5), part(points, 3, 5, 64), other(points, 3, 6);
    for (int k = 0; k < 64; ++k) whole.next();
    for (int k = 0; k < 64; ++k) {
      const auto expected = whole.next();
      EXPECT_EQ(part.next(), expected);
      EXPECT_NE(other.next(), expected);  // equal by chance once in 2^128
    }
  }
}

// Points are uniform in every coordinate. The mean of x^2 over 4096 points is 1/3 within 5 standard errors of sqrt(4/45
// / 4096). Sobol' points are far nearer.
TEST(Points, AreUniform) {
  for (const Points points : {Points::random, Points::sobol}) {
    PointSource source(points, 1, 1);
    double sums[kDimensions] = {};
    for (int k = 0; k < 4096; ++k) {
      const auto p = source.next();
      for (uint32_t d = 0; d < kDimensions; ++d) sums[d] += p[d] * 0x1p-32 * p[d] * 0x1p-32 / 4096;
    }
    for (const double sum : sums) EXPECT_NEAR(sum, 1 / 3.0, 5 * std::sqrt(4 / 45.0 / 4096));
  }
}

TEST(HemicubeWeights, AddUpToOneAndMatchTheirPixels) {
  for (const uint32_t resolution : {2u, 32u, 256u}) {
    const std::vector<double> weights = hemicubeWeights(resolution);
    double sum = 0;
    for (const double w : weights) {
      EXPECT_GT(w, 0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1, 1e-10) << resolution;  // 3 x 256^2 pixels, each of 4 integrals good to 1e-16
  }
  // Cohen & Greenberg take the weight at the middle of a pixel. The next term of the midpoint rule is the second
  // derivative times p^2 / 12, at most 4 p^2 / 12 of the weight. Three times this term is allowed.
  constexpr uint32_t kResolution = 64;
  const std::vector<double> weights = hemicubeWeights(kResolution);
  const double p = 2.0 / kResolution, area = p * p;
  for (uint32_t y = 0; y < kResolution; ++y)
    for (uint32_t x = 0; x < kResolution; ++x) {
      const double s = -1 + (x + 0.5) * p, t = -1 + (y + 0.5) * p,
                   top = area / (std::numbers::pi * std::pow(1 + s * s + t * t, 2));
      EXPECT_NEAR(weights[y * 3 * kResolution + x] / top, 1, p * p) << x << ' ' << y;
      const HemicubeFace side = hemicubeFace(1, kResolution);
      if (y >= side.height) continue;
      const double z = (y + 0.5) * p, w = area * z / (std::numbers::pi * std::pow(1 + s * s + z * z, 2));
      EXPECT_NEAR(weights[(side.y + y) * 3 * kResolution + side.x + x] / w, 1, p * p) << x << ' ' << y;
    }
}

TEST(ExchangeMatrix, ErrorsCombineBothFormFactors) {
  ExchangeMatrix reference(3), measured(3);
  reference.at(0, 1) = 0.5;
  measured.at(1, 0) = 0.7;
  reference.at(0, 2) = measured.at(2, 0) = 0.25;
  measured.at(1, 2) = 0.1;  // the reference is 0 here, so this pair has no weight
  const MatrixError error = errorOf(measured, reference, {1, 2, 4});
  const double e01 = 0.2, e10 = 0.1, e12 = 0.05, e21 = 0.025;
  EXPECT_NEAR(error.rms, std::sqrt((e01 * e01 + e10 * e10 + e12 * e12 + e21 * e21) / 6), 1e-15);
  EXPECT_NEAR(error.largest, 0.2, 1e-15);
  EXPECT_NEAR(error.weighted_rms, std::sqrt(0.5 * (e01 * e01 + e10 * e10) / (2 * 0.75)), 1e-15);
  EXPECT_NEAR(error.weighted_largest, 0.2, 1e-15);
  EXPECT_EQ(errorOf(reference, reference, {1, 2, 4}).largest, 0);
}

TEST(Generate, RefinedScenesCoverTheSame) {
  InputScene input = twoPlates(1);
  input.faces.push_back({{{3, 0, 0}, {4, 0, 0}, {3, 2, 0}}, 0, 0});
  const Scene scene = buildScene(input);
  const InputScene fine = refined(scene, 3);
  EXPECT_EQ(fine.faces.size(), 27u);
  const Scene refined_scene = buildScene(fine);
  double area = 0;
  for (const Polygon& polygon : refined_scene.polygons) {
    area += polygon.area * refined_scene.scale * refined_scene.scale;
    EXPECT_NEAR(polygon.area * refined_scene.scale * refined_scene.scale, 1 / 9.0,
                1e-14);  // all faces have area 1, cut into 9
  }
  EXPECT_NEAR(area, 3, 1e-13);
}

// Of the areas 2, 1 and 4 exchange areas of 0.5, 0.25 and 0.125 leave 1.25, 0.375 and 3.625.
TEST(ExchangeMatrix, RowsLeaveTheirAreaLessWhatPairsTake) {
  ExchangeMatrix exchange(3);
  exchange.at(0, 1) = 0.5;
  exchange.at(0, 2) = 0.25;
  exchange.at(1, 2) = 0.125;
  const std::vector<double> areas{2, 1, 4}, rest = restOf(exchange, areas);
  EXPECT_EQ(rest, (std::vector<double>{1.25, 0.375, 3.625}));
  const RestError none = errorOfRest(rest, rest, areas), some = errorOfRest({1.25, 0.875, 1.625}, rest, areas);
  EXPECT_EQ(none.largest, 0);
  EXPECT_EQ(some.largest, 0.5);
  EXPECT_DOUBLE_EQ(some.rms, std::sqrt(0.5 / 3));
}

}  // namespace
}  // namespace viewpeel::bench
