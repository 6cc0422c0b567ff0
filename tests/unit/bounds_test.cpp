// The contribution of a direction never exceeds its range, and no range is much larger than necessary.
#include "estimator/bounds.h"

#include <gtest/gtest.h>
#include <random>

#include <glm/geometric.hpp>

#include "tests/support/cpu_twin.h"
#include "directions/sampler.h"
#include "scenes/named_scenes.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

// Returns area, perimeter and diameter of the first polygon, in unit-ball units.
ConvexSize sizeOf(const Scene& scene) {
  const Polygon& polygon = scene.polygons[0];
  ConvexSize size;
  size.area = polygon.area;
  for (uint32_t k = 0; k < polygon.corner_count; ++k)
    for (uint32_t m = 0; m < k; ++m) {
      const double distance =
          glm::length(scene.corners[polygon.first_corner + k] - scene.corners[polygon.first_corner + m]);
      size.diameter = std::max(size.diameter, distance);
      if (m + 1 == k || (m == 0 && k + 1 == polygon.corner_count)) size.perimeter += distance;
    }
  return size;
}

uint64_t totalOf(const PairCounts& counts) {
  uint64_t total = 0;
  for (const PairCount& c : counts) total += c.count;
  return total;
}

// A single polygon is seen along random directions and along its normal, on lattices whose spacing divides its sides.
// Its counts stay within the ranges (27) and (28) of docs/method.md.
TEST(Bounds, RangesHoldForEveryDirectionAndLattice) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.02, 1);
  double most_points = 0, most_rows = 0;  // largest sums in units of twice the area
  for (int trial = 0; trial < 60; ++trial) {
    InputScene input{"polygon", {}, {}};
    const double width = trial % 3 == 0 ? 1 : uniform(random), skew = trial % 3 == 0 ? 0 : uniform(random) - 0.5;
    if (trial % 2) ts::addFace(input, "p", {{0, 0, 0}, {width, 0, 0}, {skew, 1, 0}});
    else ts::addFace(input, "p", ts::parallelogram({0, 0, 0}, {width, 0, 0}, {skew, 1, 0}));
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, true);
    const ConvexSize size = sizeOf(scene);
    for (int resolution : {1, 2, 5, 16}) {
      const double h = 2.0 / resolution;
      std::vector<Direction> directions = sampleDirections(Sampler::iid, 20, trial, 0);
      for (double offset : {0.0, 0.25, 0.5, 0.75}) {
        directions.push_back({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {offset, offset}});
        directions.push_back({{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {offset, offset}});
      }
      for (const Direction& direction : directions) {
        // A line through a two-sided polygon counts on both sides, so a point stands for 2 h^2.
        const double points = h * h * double(totalOf(countPairsOnCpu(scene, ids, {direction}, resolution)));
        const double rows = h * h / 1024 * double(totalOf(countIntervalsOnCpu(scene, ids, {direction}, resolution)));
        EXPECT_LE(points, latticeRange(size, h) * (1 + 1e-6));  // snapping moves corners by 2^-24 or less
        EXPECT_LE(rows, scanlineRange(size, h) * (1 + 1e-6));
        most_points = std::max(most_points, points / (2 * size.area));
        most_rows = std::max(most_rows, rows / (2 * size.area));
      }
    }
  }
  // Negative control: bounds without the terms in h would fail.
  EXPECT_GT(most_points, 1.5);
  EXPECT_GT(most_rows, 1.5);
}

TEST(Bounds, ALatticeThatFitsASquareNearlyReachesTheRange) {
  // A closed square of side n h holds (n + 1)^2 points, which is A / h^2 + p / (2 h) + 1.
  const ConvexSize square{9, 12, 3 * std::sqrt(2.0)};
  EXPECT_DOUBLE_EQ(latticeRange(square, 1), 2 * 16);
  // Four rows of length 3 lie on the square, 12 in all. The range allows 9 + 3 sqrt 2.
  EXPECT_GE(scanlineRange(square, 1), 2 * 12);
  EXPECT_LE(scanlineRange(square, 1), 2 * 13.26);
}

TEST(Bounds, FormFactorRangeTakesTheSmallerPolygon) {
  EXPECT_DOUBLE_EQ(formFactorRange(4, 3, 2), 1.5);
  EXPECT_DOUBLE_EQ(formFactorRange(3, 4, 2), 1.5);
}

}  // namespace
}  // namespace viewpeel
