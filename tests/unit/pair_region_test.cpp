// The region of directions of a pair holds every line between its polygons, and no direction along which there is none.
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

using Vec3 = glm::vec<3, long double>;

// Returns a random point of the polygon, often near its border or a corner.
Vec3 pointIn(const Corners& corners, Random& random) {
  const double sharpness = std::array{1.0, 3.0, 20.0, 100.0}[(size_t)random.uniform(0, 4)];
  Vec3 point(0);
  long double sum = 0;
  for (const glm::dvec3& corner : corners) {
    const long double weight = std::pow(random.uniform(1e-3, 1), sharpness);
    point += weight * Vec3(corner);
    sum += weight;
  }
  return point / sum;
}

// The region holds every line from front to front, unless the line grazes a front within the rounding of corners.
TEST(PairRegion, MissesNoLine) {
  for (const Case& pair : cases())
    for (uint64_t seed : {0, 7}) {
      const PairScene placed = sceneOf(pair, seed);
      const DirectionRegion region = regionOf(placed.scene);
      const Vec3 front_a = placed.scene.planes[placed.scene.polygons[0].plane].normal;
      const Vec3 front_b = placed.scene.planes[placed.scene.polygons[1].plane].normal;
      Random random(5 + seed);
      int lines = 0, missed = 0;
      for (int k = 0; k < 8000; ++k) {
        const Vec3 d = pointIn(placed.b, random) - pointIn(placed.a, random);
        if (glm::length(d) < 1e-9L) continue;
        const Vec3 u = glm::normalize(d);
        if (glm::dot(front_a, u) <= 1e-14L || glm::dot(front_b, u) >= -1e-14L) continue;
        // Rounding of touching corners turns short lines.
        if (seed != 0 && glm::length(d) < 0.1L) continue;
        ++lines;
        missed += !region.contains(glm::dvec3(u));
      }
      EXPECT_EQ(missed, 0) << pair.name << ", seed " << seed << ", of " << lines << " lines";
      if (!pair.name.starts_with("random")) {
        EXPECT_GT(lines, 100) << pair.name;
      }
    }
}

TEST(PairRegion, CheckSeesMissedLines) {
  const PairScene placed = sceneOf(cases()[0]);
  DirectionRegion region = regionOf(placed.scene);
  region.clip(glm::dvec3(1, 0, 0));
  region.close();
  Random random(5);
  int missed = 0;
  for (int k = 0; k < 8000; ++k)
    missed += !region.contains(glm::normalize(glm::dvec3(pointIn(placed.b, random) - pointIn(placed.a, random))));
  EXPECT_GT(missed, 0);
}

// Some line along a direction meets both polygons if and only if the region holds the direction or its opposite.
TEST(PairRegion, IsWhereThePairAreaIsPositive) {
  int inside = 0, outside = 0;
  for (const Case& pair : cases()) {
    if (pair.name == "squares at distance 1e-9") continue;  // the exact path takes these squares as touching
    const PairScene placed = sceneOf(pair, 3);
    const DirectionRegion region = regionOf(placed.scene);
    std::vector<glm::dvec3> directions;
    Random random(17);
    for (int k = 0; k < 300; ++k) directions.push_back(random.direction());
    const auto found = reference::computeExactPairAreas(placed.scene, directions);
    for (size_t k = 0; k < directions.size(); ++k) {
      bool meets = false;
      for (const reference::PairArea& area : found[k].pairs) meets |= area.a == 0 && area.b == 1 && area.area > 1e-14;
      const bool held = region.contains(directions[k]) || region.contains(-directions[k]);
      EXPECT_EQ(held, meets) << pair.name << ", direction " << k;
      (held ? inside : outside)++;
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
}

// Solid angles equal closed forms: of a half sphere, of a lune, and of the pyramid between two squares, 4 asin(1/2) sr
// at distance 1.
TEST(PairRegion, SolidAngleOfSimpleRegions) {
  const auto solidAngleOf = [](const char* name, uint64_t seed) {
    const auto pair = std::ranges::find(cases(), name, &Case::name);
    return regionOf(sceneOf(*pair, seed).scene).solidAngle();
  };
  EXPECT_NEAR(DirectionRegion::hemisphere({0, 0.6, 0.8}).solidAngle(), 2 * kPi, 1e-14);
  for (uint64_t seed : {0, 1, 2}) {
    EXPECT_NEAR(solidAngleOf("squares at distance 1", seed), 4 * std::asin(0.5), 1e-12);
    EXPECT_NEAR(solidAngleOf("squares at distance 10", seed), 4 * std::asin(1 / 101.0), 1e-13);
    // At distance 1e-3 the half width is 1000 distances.
    EXPECT_NEAR(solidAngleOf("squares at distance 1e-3", seed), 4 * std::asin(1e6 / (1e6 + 1)), 1e-9);
    // Near a common edge lines go all ways that the two planes allow, which is a lune.
    EXPECT_NEAR(solidAngleOf("common edge, 90 degrees", seed), kPi, 1e-12);
    EXPECT_NEAR(solidAngleOf("common edge, 1 degree", seed), 2 * kPi * 179 / 180, 1e-12);
    EXPECT_NEAR(solidAngleOf("common edge, 179 degrees", seed), 2 * kPi / 180, 1e-12);
  }
  EXPECT_EQ(DirectionRegion().solidAngle(), 0);
}

// The share of uniform directions that lie in the region gives its solid angle, within 5 standard errors. The
// false-alarm rate of 58 comparisons is 3e-5.
TEST(PairRegion, SolidAngleIsTheShareOfUniformDirections) {
  const int count = 100000;
  for (const Case& pair : cases()) {
    const DirectionRegion region = regionOf(sceneOf(pair, 11).scene);
    Random random(23);
    int inside = 0;
    for (int k = 0; k < count; ++k) inside += region.contains(random.direction());
    const double share = region.solidAngle() / (4 * kPi);
    EXPECT_NEAR(double(inside) / count, share, 5 * std::sqrt(share * (1 - share) / count) + 1e-12) << pair.name;
  }
}

// map() keeps areas: a part of the region, cut off by a plane, receives its share of an even grid.
TEST(PairRegion, MapKeepsAreas) {
  for (const Case& pair : cases()) {
    const DirectionRegion region = regionOf(sceneOf(pair, 13).scene);
    if (region.isEmpty()) continue;
    const int around = 251, outwards = 241, count = around * outwards;
    Random random(31);
    const glm::dvec3 centre = region.map(0, 0);
    for (int cut = 0; cut < 4; ++cut) {
      // The plane passes near the middle of the region.
      const glm::dvec3 point = region.map(random.uniform(), random.uniform(0, 0.3));
      DirectionRegion part = region;
      const glm::dvec3 normal = glm::normalize(glm::cross(point, glm::cross(centre, random.direction())));
      part.clip(normal);
      part.close();
      int inside = 0;
      for (int i = 0; i < around; ++i)
        for (int j = 0; j < outwards; ++j) {
          const glm::dvec3 u = region.map((i + 0.5) / around, (j + 0.5) / outwards);
          if (i % 25 == 0) {
            EXPECT_TRUE(region.contains(u)) << pair.name << " " << i << " " << j;
            EXPECT_NEAR(glm::length(u), 1, 1e-15);
          }
          inside += glm::dot(normal, u) >= 0;
        }
      // The cut is a curve that meets every row and column of the grid at most four times, so it crosses at most 4
      // cells in each. In slivers cells are folded unevenly, which doubles the number.
      const double bound = 8.0 * (around + outwards) / count;
      EXPECT_NEAR(double(inside) / count, part.solidAngle() / region.solidAngle(), bound) << pair.name;
    }
  }
}

TEST(PairRegion, IsEmptyWhereFrontsDoNotFace) {
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const std::vector<Case> blind = {
      {"facing away", square, flipped(squareAbove(1))},
      {"behind", square, flipped(squareAbove(-1))},
      {"back to back", flipped(square), flipped(squareAbove(1))},
      {"coplanar neighbours", square, rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0})},
      {"coplanar, opposite, apart", square, flipped(rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}))},
      {"convex edge", square, flipped(hinged(kPi / 2))},
      {"steps of a stair", square, rectangle({0, 0, -1}, {0, 0, 1}, {0, 1, 0})}};
  for (const Case& pair : blind)
    for (uint64_t seed : {0, 1}) {
      const PairScene placed = sceneOf(pair, seed);
      const DirectionRegion region = regionOf(placed.scene);
      EXPECT_TRUE(region.isEmpty()) << pair.name;
      EXPECT_EQ(region.solidAngle(), 0);
      EXPECT_FALSE(region.contains({0, 0, 1}));
      const DrawnDirections drawn = sampleRegion(region, 10, 1, 0);
      EXPECT_TRUE(drawn.directions.empty());
      EXPECT_EQ(drawn.weight_unit, 0);
      if (pair.name == "convex edge") {
        EXPECT_FALSE(findPairRegion(placed.scene, std::array{0u}, std::array{1u}, true).isEmpty());
      }
    }
}

// Two fronts in contact see each other at distance 0, along every direction of a half sphere.
TEST(PairRegion, OfPolygonsInContactIsAHalfSphere) {
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (uint64_t seed : {0, 1}) {
    const PairScene placed =
        sceneOf({"contact", square, flipped(rectangle({0.5, 0.5, 0}, {1, 0, 0}, {0, 1, 0}))}, seed);
    EXPECT_NEAR(regionOf(placed.scene).solidAngle(), 2 * kPi, 1e-14);
  }
}

}  // namespace
}  // namespace viewpeel
