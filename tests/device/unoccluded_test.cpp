// These tests compare exchange areas of pairs that nothing blocks with contour integrals and closed forms of
// reference/.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "tests/support/unoccluded_pairs.h"

namespace viewpeel {
namespace {

INSTANTIATE_TEST_SUITE_P(Everywhere, Unoccluded, testing::Bool(),
                         [](const auto& where) { return where.param ? "Host" : "Device"; });

// Compares every pair with the contour integral.
void expectReference(const std::vector<CornerPair>& pairs, const std::string& what) {
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, what);
  for (uint32_t k = 0; k < pairs.size(); ++k) {
    const uint32_t smaller = scene.polygons[2 * k].area <= scene.polygons[2 * k + 1].area ? 2 * k : 2 * k + 1;
    const double truth = reference::formFactor(cornersOf(scene, smaller), cornersOf(scene, smaller ^ 1u));
    EXPECT_TRUE(isAccurate(outcome.factors[k], truth, reference::kContourError)) << what << ", pair " << k;
  }
}

TEST_P(Unoccluded, RandomPairs) {
  constexpr uint64_t kSeed = 41;
  Random random(kSeed);
  for (const auto& [most, ratio] :
       {std::pair(3.0, 1.001), std::pair(30.0, 1.001), std::pair(1000.0, 30.0), std::pair(3.0, 300.0)}) {
    std::vector<CornerPair> pairs;
    for (int k = 0; k < 300; ++k) pairs.push_back(randomPair(random, most, ratio));
    expectReference(pairs, fmt::format("seed {}, distance to {}, sizes to 1:{}", kSeed, most, ratio));
  }
}

TEST_P(Unoccluded, CommonEdgesFrom1To179Degrees) {
  Random random(42);
  std::vector<CornerPair> pairs;
  for (double angle_deg : {1.0, 2.0, 5.0, 15.0, 30.0, 60.0, 90.0, 120.0, 150.0, 170.0, 178.0, 179.0})
    for (double length : {0.01, 0.5, 1.0, 20.0, 100.0}) {
      const double angle_rad = angle_deg * kPi / 180;
      const glm::dvec3 o(0), p(1, 0, 0), q(std::cos(angle_rad), std::sin(angle_rad), 0), z(0, 0, length);
      pairs.push_back({rectangle(o, z, p), rectangle(o, q, z)});
      pairs.push_back({{o, z, p}, {o, q, z}});                                 // triangles at the same edge
      pairs.push_back({rectangle(o, z, p), rectangle(0.3 * z, q, z)});         // a part of the edge in common
      pairs.push_back({rectangle(o, z, p), rectangle(0.25 * z, q, 0.5 * z)});  // an edge within the other
      pairs.push_back({rectangle(o, z, p), rectangle(z, q, z)});               // only a corner in common
      pairs.push_back({rectangle(o, z, p), rectangle(o, 0.1 * q, z)});
    }
  expectReference(pairs, "common edges");
}

struct ExpectedPair {
  CornerPair pair;
  double truth;  // form factor from a, which must be the smaller polygon
};

// Compares pairs with closed forms. Corners are scaled to the unit ball and rounded; truth_error bounds the effect on
// the form factor.
void expectFactors(const std::vector<ExpectedPair>& expected, const std::string& what, double truth_error) {
  std::vector<CornerPair> pairs;
  for (const ExpectedPair& one : expected) pairs.push_back(one.pair);
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, what);
  for (size_t k = 0; k < expected.size(); ++k)
    EXPECT_TRUE(isAccurate(outcome.factors[k], expected[k].truth, truth_error)) << what << ", pair " << k;
}

TEST_P(Unoccluded, Slivers) {
  for (double width : {1e-2, 1e-4, 1e-5, 1e-6}) {
    const Corners floor = rectangle({0, 0, 0}, {width, 0, 0}, {0, 1, 0}),
                  wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    const Corners thin_wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, width});
    std::vector<ExpectedPair> expected{
        {{floor, wall}, reference::perpendicularRectangles({0, width}, {0, 1}, {0, 1}, {0, 1})},
        {{floor, thin_wall}, reference::perpendicularRectangles({0, width}, {0, 1}, {0, 1}, {0, width})},
        {{floor, moved(thin_wall, 1, {0, 0.5, 0})},
         reference::perpendicularRectangles({0, width}, {0, 1}, {0.5, 1.5}, {0, width})},
        {{moved(floor, 1, {0.5, 0, 0}), wall},
         reference::perpendicularRectangles({0.5, 0.5 + width}, {0, 1}, {0, 1}, {0, 1})},
    };
    for (double distance : {width, 100 * width, 0.1, 3.0}) {
      const Corners above = flipped(moved(floor, 1, {0, 0, distance})),
                    square = rectangle({0, 0, distance}, {0, 1, 0}, {1, 0, 0});
      expected.push_back(
          {{floor, above}, reference::parallelRectangles({0, width}, {0, 1}, {0, width}, {0, 1}, distance)});
      expected.push_back(
          {{floor, square}, reference::parallelRectangles({0, width}, {0, 1}, {0, 1}, {0, 1}, distance)});
    }
    expectFactors(expected, fmt::format("slivers {} wide", width), 1e-10);
  }
}

// These polygons are 1e4 to 1e6 times as long as wide, and near each other in any position.
TEST_P(Unoccluded, RandomSlivers) {
  constexpr uint64_t kSeed = 49;
  Random random(kSeed);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 150; ++k) {
    CornerPair pair = randomPair(random, 3, 1.001);
    const double thin = std::exp(random.uniform(std::log(1e-6), std::log(1e-4)));
    const glm::dvec3 corner = pair.a[0], normal = glm::cross(pair.a[1] - corner, pair.a[2] - corner),
                     across = glm::normalize(glm::cross(normal, random.direction()));
    for (glm::dvec3& x : pair.a) x -= (1 - thin) * glm::dot(x - corner, across) * across;
    pairs.push_back(pair);
  }
  expectReference(pairs, fmt::format("seed {}, slivers", kSeed));
}

// Gaps go down to widths at which polygons count as coplanar. Such polygons exchange the area of their overlap, which
// is the limit. Each pair is a scene of its own, for stacked plates would coincide with each other.
TEST_P(Unoccluded, ParallelPlatesCloseTogether) {
  for (double gap : {1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 0.0})
    for (double shift : {0.0, 0.3, 0.999}) {
      SCOPED_TRACE(fmt::format("gap {}, shift {}", gap, shift));
      const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    above = rectangle({shift, 0.1, gap}, {0, 1, 0}, {1, 0, 0});
      const double truth =
          reference::parallelRectangles({0, 1}, {0, 1}, {shift, 1 + shift}, {0.1, 1.1}, std::max(gap, 1e-13));
      // Rounding of corners moves the plates by at most 2^-53, for the ball is about as large as they are. The form
      // factor changes with the gap.
      constexpr double kRounding = 1e-10;
      // Two plates without a gap, alone in space, are the sides of a sheet unless the user says that they belong to
      // solids.
      const SceneOptions solids{.solids = {"all"}};
      const Outcome between = computeBothWays(sceneOf({{floor, above}}, gap > 0 ? SceneOptions{} : solids), "plates");
      EXPECT_TRUE(isAccurate(between.factors[0], truth, kRounding));
      if (gap > 0) continue;
      EXPECT_EQ(computeBothWays(sceneOf({{floor, above}}), "sheet").factors[0], 0);
    }
}

TEST_P(Unoccluded, NearlyCoplanar) {
  std::vector<CornerPair> pairs;
  for (double angle_deg : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    const double angle_rad = angle_deg * kPi / 180;
    const glm::dvec3 p(-1, 0, 0), q(std::cos(angle_rad), 0, std::sin(angle_rad)), y(0, 1, 0);
    pairs.push_back({rectangle({0, 0, 0}, y, p), rectangle({0, 0, 0}, q, y)});     // a common edge
    pairs.push_back({rectangle({-0.2, 0, 0}, y, p), rectangle({0, 0, 0}, q, y)});  // apart
    pairs.push_back({rectangle({0, 0, 0}, y, p), rectangle({0, 1, 0}, q, y)});     // a common corner
    if (angle_deg > 5e-3)
      pairs.push_back({rectangle({-1, 0, 0}, {3, 0, 0}, y),
                       rectangle({0, 0.2, angle_rad}, {0.3, 0, 0}, {0, 0, angle_rad})});  // a step of small height
  }
  expectReference(pairs, "nearly coplanar");
}

// Polygons lie near each other in random planes, and most reach behind the plane of the other.
TEST_P(Unoccluded, ClipsWhatReachesBehind) {
  Random random(43);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 400; ++k) {
    const glm::dvec3 apart = random.direction() * std::exp(random.uniform(std::log(0.5), std::log(20.0)));
    pairs.push_back({random.convexPolygon(glm::dvec3(0), random.direction(), 3 + k % 2),
                     random.convexPolygon(apart, random.direction(), 3 + k / 2 % 2)});
  }
  // A wall stands along two edges of a floor, in its middle, or along its diagonal.
  const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (double x : {0.0, 0.5, 1.0}) pairs.push_back({floor, rectangle({x, 0, -1}, {0, 1, 0}, {0, 0, 2})});
  pairs.push_back({floor, rectangle({1, 0, -1}, {-1, 1, 0}, {0, 0, 2})});
  expectReference(pairs, "seed 43, any directions");
}

// Returns whether each polygon lies wholly in front of the other.
bool areWhole(const CornerPair& pair) {
  const auto isBefore = [](const Corners& plane, const Corners& corners) {
    const glm::dvec3 normal = glm::cross(plane[1] - plane[0], plane[2] - plane[0]);
    return std::all_of(corners.begin(), corners.end(),
                       [&](const glm::dvec3& x) { return glm::dot(normal, x - plane[0]) > 0; });
  };
  return isBefore(pair.a, pair.b) && isBefore(pair.b, pair.a);
}

// The product rule's bound, of the relative error, holds for pairs all around, also of thin, skew and grazing shapes.
TEST_P(Unoccluded, FarPairsToRelativeError) {
  constexpr uint64_t kSeed = 44;
  Random random(kSeed);
  std::vector<CornerPair> pairs;
  for (int k = 0; pairs.size() < 1200; ++k) {
    const glm::dvec3 towards = random.direction();
    const auto facing = [&](glm::dvec3 d) {
      return glm::normalize(d * (k % 3 ? 1.0 : 0.2) + 0.9 * random.direction());
    };
    Corners a = random.convexPolygon(glm::dvec3(0), facing(towards), 3 + k % 2);
    const Corners b = random.convexPolygon(glm::dvec3(0), facing(-towards), 3 + k / 2 % 2);
    const glm::dvec3 side = glm::normalize(a[1] - a[0]);
    if (k % 5 == 0)  // thin
      for (glm::dvec3& corner : a) corner -= 0.99 * glm::dot(corner, side) * side;
    // Pairs are placed apart, for polygons that cross at a small angle might coincide.
    const glm::dvec3 place = 5.0 * glm::dvec3(k % 12, k / 12 % 12, k / 144);
    const double distance = std::exp(random.uniform(std::log(9.0), std::log(k % 10 == 0 ? 1e4 : 100.0)));
    const CornerPair pair{moved(a, 1, place), moved(b, 1, place + towards * distance)};
    if (areWhole(pair)) pairs.push_back(pair);
  }
  // Parallel squares far to the side of each other, with edges in line, come closest to the error allowed.
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (int k = 0; k < 200; ++k) pairs.push_back({square, flipped(moved(square, 1, {4 * std::pow(1.02, k), 0, 0.3}))});
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, "far pairs");
  EXPECT_EQ(outcome.work.near_pairs, 0u);
  for (uint64_t count : outcome.work.far_pairs) EXPECT_GT(count, 0u);
  double worst = 0;
  for (uint32_t k = 0; k < pairs.size(); ++k) {
    const uint32_t smaller = scene.polygons[2 * k].area <= scene.polygons[2 * k + 1].area ? 2 * k : 2 * k + 1;
    const double truth = reference::formFactor(cornersOf(scene, smaller), cornersOf(scene, smaller ^ 1u));
    EXPECT_LE(std::abs(outcome.factors[k] - truth), (kUnoccludedRelativeError + reference::kFarRelativeError) * truth)
        << "seed " << kSeed << ", pair " << k;
    worst = std::max(worst, std::abs(outcome.factors[k] / truth - 1));
  }
  EXPECT_GT(worst, 0.1 * kUnoccludedRelativeError);  // the rules are not far too fine
}

}  // namespace
}  // namespace viewpeel
