// Exchange areas of pairs with nothing in between, against the reference's closed forms.
#include "scene/group_planes.h"
#include "unoccluded/unoccluded.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/rectangles.h"
#include "tests/support/reference_shapes.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

using reference::test::areaOf;
using reference::test::boxFaces;
using reference::test::Corners;
using reference::test::flipped;
using reference::test::moved;
using reference::test::Random;
using reference::test::rectangle;

constexpr double kPi = std::numbers::pi;

struct CornerPair {
  Corners a, b;
};

// Polygons 2k and 2k + 1 are a pair, each pair built as a scene of its own. Polygons of different pairs may lie
// anywhere, across each other or in one place: no pair depends on another one.
Scene sceneOf(const std::vector<CornerPair>& pairs, const SceneOptions& options = {}) {
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

Corners cornersOf(const Scene& scene, uint32_t polygon) {
  const Polygon& p = scene.polygons[polygon];
  return {scene.corners.begin() + p.first_corner, scene.corners.begin() + p.first_corner + p.corner_count};
}

// F from the smaller polygon.
double largerFactor(const Scene& scene, uint32_t i, uint32_t j, double exchange_area) {
  return exchange_area / std::min(scene.polygons[i].area, scene.polygons[j].area);
}

double allowedError(double form_factor) {
  return std::max(kUnoccludedRelativeError * form_factor, kUnoccludedAbsoluteError);
}

testing::AssertionResult isAccurate(double form_factor, double truth, double truth_error) {
  if (std::abs(form_factor - truth) <= allowedError(truth) + truth_error) return testing::AssertionSuccess();
  return testing::AssertionFailure() << fmt::format("{} is off {} by {}, allowed {}", form_factor, truth,
                                                    form_factor - truth, allowedError(truth) + truth_error);
}

bool on_host = false;  // whether this run of a test is about the processor

UnoccludedExchange makeExchange(const Scene& scene, const UnoccludedOptions& options = {}) {
  return on_host ? UnoccludedExchange(scene, options) : UnoccludedExchange(testDevice(), scene, options);
}

class Unoccluded : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override { on_host = GetParam(); }
};
INSTANTIATE_TEST_SUITE_P(Everywhere, Unoccluded, testing::Bool(),
                         [](const auto& where) { return where.param ? "Host" : "Device"; });

struct Outcome {
  std::vector<double> factors;  // from the smaller polygon
  UnoccludedWork work;
};

// All pairs in both orders: the same bits, none short of the accuracy.
Outcome computeBothWays(const Scene& scene, const std::string& what) {
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

// Every pair against the contour integral.
void expectReference(const std::vector<CornerPair>& pairs, const std::string& what) {
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, what);
  for (uint32_t k = 0; k < pairs.size(); ++k) {
    const uint32_t smaller = scene.polygons[2 * k].area <= scene.polygons[2 * k + 1].area ? 2 * k : 2 * k + 1;
    const double truth = reference::formFactor(cornersOf(scene, smaller), cornersOf(scene, smaller ^ 1u));
    EXPECT_TRUE(isAccurate(outcome.factors[k], truth, reference::kContourError)) << what << ", pair " << k;
  }
}

// Triangles and quadrilaterals, their distance 0.3 to `most` sizes, log-uniform; sizes in a ratio up to `ratio`.
CornerPair randomPair(Random& random, double most, double ratio) {
  const glm::dvec3 towards = random.direction();
  const auto facing = [&random](glm::dvec3 d) { return glm::normalize(d + 0.9 * random.direction()); };
  const double size = std::exp(random.uniform(0, std::log(ratio))),
               distance = std::exp(random.uniform(std::log(0.3), std::log(most)));
  const Corners a = random.convexPolygon(glm::dvec3(0), facing(towards), 3 + (int)random.uniform(0, 2));
  const Corners b = moved(random.convexPolygon(glm::dvec3(0), facing(-towards), 3 + (int)random.uniform(0, 2)),
                          1 / size, distance * towards);
  return {a, b};
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
      pairs.push_back({{o, z, p}, {o, q, z}});                                 // triangles on the same edge
      pairs.push_back({rectangle(o, z, p), rectangle(0.3 * z, q, z)});         // part of the edge
      pairs.push_back({rectangle(o, z, p), rectangle(0.25 * z, q, 0.5 * z)});  // within the edge
      pairs.push_back({rectangle(o, z, p), rectangle(z, q, z)});               // a corner only
      pairs.push_back({rectangle(o, z, p), rectangle(o, 0.1 * q, z)});
    }
  expectReference(pairs, "common edges");
}

struct ExpectedPair {
  CornerPair pair;
  double truth;  // F from a, which must be the smaller
};

// Closed forms of rectangles; corners are scaled to the unit ball, which rounds them: corner_rounding bounds what that
// does to F.
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

// Triangles and quadrilaterals 1e4 to 1e6 times as long as wide, near each other in any position.
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

// Gaps down to less than what makes polygons coplanar: those exchange the area of their overlap, which is the limit.
// Each pair is a scene of its own, for piled plates would coincide with each other.
TEST_P(Unoccluded, ParallelPlatesCloseTogether) {
  for (double gap : {1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 0.0})
    for (double shift : {0.0, 0.3, 0.999}) {
      SCOPED_TRACE(fmt::format("gap {}, shift {}", gap, shift));
      const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    above = rectangle({shift, 0.1, gap}, {0, 1, 0}, {1, 0, 0});
      const double truth =
          reference::parallelRectangles({0, 1}, {0, 1}, {shift, 1 + shift}, {0.1, 1.1}, std::max(gap, 1e-13));
      // Unit squares lie in a ball of about their size: a corner's rounding moves the plates by no more than 2^-53, and
      // F with the gap's size.
      constexpr double kRounding = 1e-10;
      // Without a gap plates alone in space are the two sides of a sheet, unless the user says that they are faces of
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
                       rectangle({0, 0.2, angle_rad}, {0.3, 0, 0}, {0, 0, angle_rad})});  // a low step
  }
  expectReference(pairs, "nearly coplanar");
}

// Random planes through each other's neighbourhood: most reach behind.
TEST_P(Unoccluded, ClipsWhatReachesBehind) {
  Random random(43);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 400; ++k) {
    const glm::dvec3 apart = random.direction() * std::exp(random.uniform(std::log(0.5), std::log(20.0)));
    pairs.push_back({random.convexPolygon(glm::dvec3(0), random.direction(), 3 + k % 2),
                     random.convexPolygon(apart, random.direction(), 3 + k / 2 % 2)});
  }
  // A wall through the middle of a floor, at a corner of it, along its edge.
  const Corners floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (double x : {0.0, 0.5, 1.0}) pairs.push_back({floor, rectangle({x, 0, -1}, {0, 1, 0}, {0, 0, 2})});
  pairs.push_back({floor, rectangle({1, 0, -1}, {-1, 1, 0}, {0, 0, 2})});
  expectReference(pairs, "seed 43, any directions");
}

// Whether all corners of either lie before the other.
bool areWhole(const CornerPair& pair) {
  const auto isBefore = [](const Corners& plane, const Corners& corners) {
    const glm::dvec3 normal = glm::cross(plane[1] - plane[0], plane[2] - plane[0]);
    return std::all_of(corners.begin(), corners.end(),
                       [&](const glm::dvec3& x) { return glm::dot(normal, x - plane[0]) > 0; });
  };
  return isBefore(pair.a, pair.b) && isBefore(pair.b, pair.a);
}

// The bound on a product rule's error is relative, and holds in every direction, for thin, skew and grazing shapes too.
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
    // Pairs lie apart, for polygons across one another might coincide where they cross at a small angle.
    const glm::dvec3 place = 5.0 * glm::dvec3(k % 12, k / 12 % 12, k / 144);
    const double distance = std::exp(random.uniform(std::log(9.0), std::log(k % 10 == 0 ? 1e4 : 100.0)));
    const CornerPair pair{moved(a, 1, place), moved(b, 1, place + towards * distance)};
    if (areWhole(pair)) pairs.push_back(pair);
  }
  // Edges that point at each other: where the bound is close.
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
  EXPECT_GT(worst, 0.1 * kUnoccludedRelativeError);  // the rules are no finer than they need be
}

TEST_P(Unoccluded, PairsThatDoNotSeeEachOtherAreExactlyZero) {
  const Corners square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), above = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
  Random random(45);
  std::vector<CornerPair> pairs{
      {square, flipped(above)},
      {flipped(square), above},
      {square, moved(square, 1, {1, 0, 0})},  // coplanar, one way
      {square, moved(square, 0.5, {0.2, 0.2, 0})},
      {square, flipped(moved(square, 1, {1, 0, 0}))},  // coplanar, face to face, with a common edge
      {square, flipped(moved(square, 1, {1.5, 0, 0}))},
      {square, rectangle({0, 0, 0}, {0, 0, 1}, {0, 1, 0})},   // a common edge, the wall looks away
      {square, rectangle({0, 0, -1}, {0, 1, 0}, {0, 0, 1})},  // a common edge from below
      {square, rectangle({0.5, 0, -2}, {0, 1, 0}, {0, 0, 1})}};
  for (int k = 0; k < 50; ++k) {  // backs of a convex solid's neighbours, turned at random
    const glm::dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())),
                     z = glm::cross(x, y);
    pairs.push_back({rectangle({0, 0, 0}, x, y), rectangle({0, 0, 0}, y, -z)});
  }
  const Scene scene = sceneOf(pairs);
  const Outcome outcome = computeBothWays(scene, "unseen");
  for (size_t k = 0; k < pairs.size(); ++k) EXPECT_EQ(outcome.factors[k], 0) << k;
  std::vector<double> areas(1, -1);
  makeExchange(scene).compute(std::vector<SidePair>{{frontSide(0), backSide(0)}}, areas);
  EXPECT_EQ(areas[0], 0) << "a polygon's own sides";
}

TEST_P(Unoccluded, SidesEqualFlippedPolygons) {
  Random random(46);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 40; ++k)
    pairs.push_back({random.convexPolygon(glm::dvec3(0), random.direction(), 3 + k % 2),
                     random.convexPolygon(random.direction() * random.uniform(0.7, 9), random.direction(), 4)});
  const Scene scene = sceneOf(pairs);
  std::vector<SidePair> requested;
  std::vector<double> truths;
  for (uint32_t k = 0; k < scene.polygons.size(); k += 2)
    for (uint32_t back_a : {0u, 1u})
      for (uint32_t back_b : {0u, 1u}) {
        requested.push_back({2 * k + back_a, 2 * (k + 1) + back_b});
        const Corners a = cornersOf(scene, k), b = cornersOf(scene, k + 1);
        truths.push_back(reference::formFactor(back_a ? flipped(a) : a, back_b ? flipped(b) : b));
      }
  std::vector<double> areas(requested.size());
  EXPECT_TRUE(makeExchange(scene).compute(requested, areas).empty());
  for (size_t k = 0; k < requested.size(); ++k) {
    const double area_a = scene.polygons[requested[k].i / 2].area, area_b = scene.polygons[requested[k].j / 2].area;
    // The reference's F is from a.
    const double allowed =
        std::max(kUnoccludedRelativeError * truths[k] * area_a, kUnoccludedAbsoluteError * std::min(area_a, area_b));
    EXPECT_LE(std::abs(areas[k] - truths[k] * area_a), allowed + reference::kContourError * area_a) << "pair " << k;
  }
}

// Every polygon of a closed, convex room: its form factors add up to 1, over all classes of pairs at once.
TEST_P(Unoccluded, RoomCloses) {
  constexpr int kCuts = 6;
  Random random(47);
  const glm::dvec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())), z = glm::cross(x, y);
  InputScene input{"turned room", {"walls"}, {}};
  for (const Corners& face : boxFaces({1, 2, 0.7}))
    for (int i = 0; i < kCuts; ++i)
      for (int j = 0; j < kCuts; ++j) {
        Corners corners;
        for (const auto& [u, v] :
             {std::pair(i, j), std::pair(i + 1, j), std::pair(i + 1, j + 1), std::pair(i, j + 1)}) {
          const glm::dvec3 p =
              face[0] + (face[1] - face[0]) * (double(u) / kCuts) + (face[3] - face[0]) * (double(v) / kCuts);
          corners.push_back(p.x * x + p.y * y + p.z * z);
        }
        input.faces.push_back({corners, 0, 0});
      }
  const Scene scene = buildScene(input);
  const auto n = static_cast<uint32_t>(scene.polygons.size());
  std::vector<SidePair> pairs;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = i; j < n; ++j) pairs.push_back({frontSide(i), frontSide(j)});
  std::vector<double> areas(pairs.size()), sums(n);
  UnoccludedExchange exchange = makeExchange(scene);
  EXPECT_TRUE(exchange.compute(pairs, areas).empty());
  for (size_t k = 0; k < pairs.size(); ++k)
    for (uint32_t side : {pairs[k].i, pairs[k].j}) sums[side / 2] += areas[k];
  // Corners on a cut are rounded alike on both sides; the planes of walls to 2^-52, which moves a share of 1e-13 of
  // what leaves a patch.
  for (uint32_t i = 0; i < n; ++i)
    EXPECT_NEAR(sums[i] / scene.polygons[i].area, 1, kUnoccludedRelativeError + n * kUnoccludedAbsoluteError + 1e-12)
        << "polygon " << i;
}

TEST_P(Unoccluded, ChunksDoNotMatter) {
  Random random(48);
  std::vector<CornerPair> pairs;
  for (int k = 0; k < 60; ++k) pairs.push_back(randomPair(random, k % 2 ? 3 : 60, 2));
  for (int k = 0; k < 20; ++k) {
    const double angle_rad = random.uniform(0.02, 3.1), length = std::exp(random.uniform(-4, 4));
    pairs.push_back({rectangle({0, 0, 0}, {0, 0, length}, {1, 0, 0}),
                     rectangle({0, 0, 0}, {std::cos(angle_rad), std::sin(angle_rad), 0}, {0, 0, length})});
  }
  const Scene scene = sceneOf(pairs);
  std::vector<SidePair> requested;
  for (uint32_t k = 0; k < scene.polygons.size(); k += 2) requested.push_back({frontSide(k), frontSide(k + 1)});
  std::vector<double> whole(requested.size()), parts(requested.size());
  UnoccludedExchange large = makeExchange(scene);
  UnoccludedExchange small = makeExchange(scene, {.chunk_pairs = 11, .near_pairs = 3, .thread_count = 3});
  large.compute(requested, whole);
  small.compute(requested, parts);
  EXPECT_EQ(whole, parts);
  EXPECT_EQ(large.work().near_pairs, small.work().near_pairs);
  EXPECT_GT(small.work().again_pairs, 0u);
  EXPECT_GT(small.work().far_pairs[1], 0u);
}

// Strips so thin that rounding alone is more than the error allowed: the value is there, and so is the report.
TEST_P(Unoccluded, ReportsWhatItCannotReach) {
  constexpr double kWidth = 1e-10;
  const Scene scene =
      sceneOf({{rectangle({0, 0, 0}, {kWidth, 0, 0}, {0, 1, 0}), rectangle({0, 0, 0.1}, {0, 1, 0}, {1, 0, 0})},
               {rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 0.1}, {0, 1, 0}, {1, 0, 0})}});
  std::vector<double> areas(2);
  const std::vector<UnreachedPair> unreached =
      makeExchange(scene, {.chunk_pairs = 1})
          .compute(std::vector<SidePair>{{frontSide(2), frontSide(3)}, {frontSide(0), frontSide(1)}}, areas);
  ASSERT_EQ(unreached.size(), 1u);
  EXPECT_EQ(unreached[0].pair, 1u);
  EXPECT_GT(unreached[0].error, kUnoccludedRelativeError * areas[1]);
  const double truth = scene.polygons[0].area * reference::parallelRectangles({0, kWidth}, {0, 1}, {0, 1}, {0, 1}, 0.1);
  EXPECT_LE(std::abs(areas[1] - truth), unreached[0].error);
}

TEST_P(Unoccluded, RefusesWhatIsNotThere) {
  const Scene scene =
      sceneOf({{rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0})}});
  UnoccludedExchange exchange = makeExchange(scene);
  std::vector<double> areas(1);
  EXPECT_THROW(exchange.compute(std::vector<SidePair>{{0, 4}}, areas), Error);
  EXPECT_THROW(exchange.compute(std::vector<SidePair>{{0, 2}, {2, 0}}, areas), Error);
  EXPECT_TRUE(exchange.compute({}, {}).empty());
}

// The comparator notices a wrong value.
TEST_P(Unoccluded, WrongValuesAreNoticed) {
  EXPECT_TRUE(isAccurate(0.25, 0.25 * (1 + 9e-7), 0));
  EXPECT_FALSE(isAccurate(0.25, 0.25 * (1 + 1.1e-6), 0));
  EXPECT_FALSE(isAccurate(0, 1.1e-9, 0));
}

}  // namespace
}  // namespace viewpeel
