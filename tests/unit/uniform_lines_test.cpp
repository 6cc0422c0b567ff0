// These tests compare the share of accepted candidates with exchange areas, and visibilities with quadrature. They also
// check that streams are independent and that rounding decides no line.
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "pair_lines/find_pairs.h"
#include "pair_lines/uniform_lines.h"
#include "scenes/exact_scenes.h"
#include "scenes/named_scenes.h"
#include "scenes/stress.h"
#include "tests/support/face_pairs.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;
namespace rt = reference::test;
using Pair = test::FacePairs;
using glm::dvec3;
using rt::kCeiling, rt::kFloor, rt::rectangle;

// The error of a correct value exceeds 5.5 standard errors once in 2.6e7.
constexpr double kStandardErrors = 5.5;

TEST(UniformLines, CandidatesBecomeLinesAsOftenAsTheExchangeAreaSays) {
  // The share of accepted candidates is an integral of f, which pair.exchange states independently.
  const std::vector<std::pair<const char*, rt::Corners>> seconds = {
      {"opposite", kCeiling},
      {"far", rectangle({3, 2, 9}, {0, 1, 0}, {1, 0, 0})},
      {"touching wall", rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1})},
      {"near wall", rectangle({-0.01, 0.2, 0}, {0, 0.5, 0}, {0, 0, 1})},
      {"narrow gap", rectangle({0.1, 0.1, 0.003}, {0, 0.7, 0}, {0.6, 0, 0})},
      {"tilted triangle", {{0.2, 0.1, 0.7}, {0.4, 1.1, 0.9}, {1.0, 0.3, 0.8}}},
      {"trapezium", {{0.2, 0.1, 0.7}, {0.3, 0.6, 0.7}, {0.6, 0.6, 0.7}, {1.9, 0.1, 0.7}}},
      {"half behind", rectangle({0.5, 0.2, -0.4}, {0, 0.5, 0}, {0.1, 0, 1})},
  };
  for (const auto& [name, second] : seconds) {
    const Pair pair({kFloor, second});
    const UniformLines lines = pair.lines(pair.between(0, 1));
    const UniformLineCount count = lines.draw(7, 1'000'000, widestVectors());
    EXPECT_EQ(count.lines, 1'000'000u) << name;
    EXPECT_EQ(count.open, 0u) << name;
    EXPECT_EQ(count.facing, count.lines) << name;
    // Drawing stops at a number of lines. This biases the share by its variance over that number, far below the
    // standard error.
    const double share = double(count.lines) / double(count.candidates), e = lines.efficiency();
    EXPECT_NEAR(share, e, kStandardErrors * std::sqrt(e * (1 - e) / double(count.candidates)) + 2e-6 * e) << name;
    EXPECT_GT(e, 0.01) << name;
  }
}

// Returns the visibility from floor to ceiling of the unit cube past a blocker at `height` over x < edge. The rule has
// 60 midpoints in x and u, and 2000 in the difference of y. Cells that the edge cuts count in part.
double visibilityByQuadrature(double edge, double height) {
  constexpr int kSteps = 60;
  double seen = 0, all = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double x = (i + 0.5) / kSteps, u = (j + 0.5) / kSteps;
      // Only the difference of the y coordinates matters.
      double of_y = 0;
      for (int k = 0; k < 2000; ++k) {
        const double dy = (k + 0.5) / 2000, r2 = 1 + dy * dy + (u - x) * (u - x);
        of_y += 2 * (1 - dy) / (r2 * r2) / 2000;
      }
      all += of_y;
      // This is the share of the cell's lines that pass the edge: x (1 - height) + u height > edge.
      const double at = x * (1 - height) + u * height, half = 0.5 / kSteps;
      seen += of_y * std::clamp(0.5 + (at - edge) / (2 * half), 0.0, 1.0);
    }
  return seen / all;
}

TEST(UniformLines, VisibilitiesAgreeWithQuadrature) {
  for (const double edge : {0.2, 0.5, 0.8}) {
    const Pair pair({kFloor, kCeiling, rectangle({-2, -5, 0.3}, {edge + 2, 0, 0}, {0, 11, 0})});
    const UniformLineCount count = pair.lines(pair.between(0, 1)).draw(11, 10'000'000, widestVectors());
    const double seen = double(count.facing) / double(count.lines), truth = visibilityByQuadrature(edge, 0.3);
    // The quadrature with 60 steps differs from one with 960 steps by 1.5e-5 at most for these three edges.
    const double allowed = kStandardErrors * std::sqrt(truth * (1 - truth) / double(count.lines)) + 1e-4;
    EXPECT_NEAR(seen, truth, allowed) << edge;
    EXPECT_EQ(count.open, 0u);
    // Negative control: the visibility past a blocker that is 1 % wider is noticed.
    EXPECT_GT(std::abs(seen - visibilityByQuadrature(edge + 0.01, 0.3)), allowed) << edge;
  }
}

TEST(UniformLines, StreamsAreIndependentAndRepeatable) {
  const Pair pair({kFloor, kCeiling, rectangle({-2, -5, 0.3}, {2.5, 0, 0}, {0, 11, 0})});
  const UniformLines lines = pair.lines(pair.between(0, 1));
  const UniformLineCount one = lines.draw(1, 1000, widestVectors()), same = lines.draw(1, 1000, Vectors::plain);
  EXPECT_EQ(one.facing, same.facing);
  EXPECT_EQ(one.candidates, same.candidates);
  // The counts of 4,000 streams of 256 lines vary like binomial counts: chi-squared with 4,000 degrees of freedom,
  // within 5.5 standard deviations.
  const double s = double(lines.draw(2, 4'000'000, widestVectors()).facing) / 4e6;
  double squares = 0;
  constexpr int kStreams = 4000, kLines = 256;
  for (int stream = 0; stream < kStreams; ++stream) {
    const double facing = double(lines.draw(100 + stream, kLines, widestVectors()).facing);
    squares += std::pow(facing - kLines * s, 2) / (kLines * s * (1 - s));
  }
  EXPECT_NEAR(squares, kStreams, kStandardErrors * std::sqrt(2.0 * kStreams));
}

TEST(UniformLines, WhatRoundingMayDecideIsDecidedAgain) {
  // The blocker reaches 1e-7 into the space between the two patches. Single precision alone would count lines on either
  // side of its edge.
  const double gap = 1e-7;
  const Pair pair({kFloor, kCeiling, rectangle({-3, -5, 0.5}, {3 + gap, 0, 0}, {0, 11, 0})});
  const UniformLineCount count = pair.lines(pair.between(0, 1)).draw(3, 2'000'000, widestVectors());
  // Lines with x + u < 2 gap are blocked. Their share is below (2 gap)^2, some 1e-14.
  EXPECT_EQ(count.facing + count.open, count.lines);
  EXPECT_LE(count.open, 1u);
}

// leastDistance() is a lower bound, mostly a few per cent below the distance. In these two cases it is nearly the
// distance itself.
TEST(UniformLines, LeastDistanceIsALowerBoundAndSharp) {
  const Pair pair({kFloor, rectangle({0.3, 0.4, 0.25}, {0, 0.2, 0}, {0.2, 0, 0.1}),
                   rectangle({2, 2, 0}, {0, 0, 1}, {-0.5, 0.5, 0})});
  const auto& patches = pair.finder.patches();
  const double unit = pair.scene.scale;
  EXPECT_NEAR(leastDistance(patches[0], patches[1]) * unit, 0.25, 1e-9);
  EXPECT_LE(leastDistance(patches[0], patches[1]) * unit, 0.25 + 1e-12);
  // The nearest points are the corners (1, 1, 0) and (2, 2, 0), sqrt(2) apart.
  EXPECT_NEAR(leastDistance(patches[0], patches[2]) * unit, std::sqrt(2.0), 2e-3);
  EXPECT_LE(leastDistance(patches[0], patches[2]) * unit, std::sqrt(2.0) + 1e-12);
}

}  // namespace
}  // namespace viewpeel
