#include "reference/closed_forms/past_blocker.h"

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/rectangles.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

using test::areaOf;
using test::Corners;
using test::isWithin;
using test::rectangle;

constexpr Interval kSide{0, 1};

Corners floorSquare() { return rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}); }
Corners ceilingSquare() { return rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}); }
Corners wallSquare() { return rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1}); }
Corners level(Interval x, Interval y, double z) {
  return rectangle({x.low, y.low, z}, {x.high - x.low, 0, 0}, {0, y.high - y.low, 0});
}
Corners outOfTheWay() { return level({5, 6}, {5, 6}, 0.5); }

// Returns whether the value lies within its own error bound, and this bound within kPastBlockerError.
testing::AssertionResult isGood(const Approximation& result, double truth, double truth_error = kContourError) {
  if (!(result.error <= kPastBlockerError)) return testing::AssertionFailure() << "error " << result.error;
  return isWithin(result.value, truth, result.error + truth_error);
}

TEST(PastBlocker, BlockerOutOfTheWay) {
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), outOfTheWay()), 0.1998248957, 5e-11));
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), wallSquare(), outOfTheWay()), 0.2000437761, 5e-11));
  EXPECT_FALSE(isGood(formFactorPastBlocker(floorSquare(), wallSquare(), outOfTheWay()), 0.2000437761 + 2.1e-7, 5e-11));
}

TEST(PastBlocker, RandomPairsWithNothingBetweenAgreeWithContourIntegral) {
  test::Random random(31);
  for (int trial = 0; trial < 20; ++trial) {
    const auto [a, b] = test::randomPair(random);
    EXPECT_TRUE(isGood(formFactorPastBlocker(a, b, level({50, 51}, {50, 51}, 3)), formFactor(a, b)))
        << "trial " << trial;
  }
}

TEST(PastBlocker, BlockerThatHidesAll) {
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), level({-1, 2}, {-1, 2}, 0.5)), 0));
  // This blocker is as large as the squares, and just suffices.
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), level({0, 1}, {0, 1}, 0.5)), 0));
}

TEST(PastBlocker, FrontOfTheBlockerDoesNotMatter) {
  const Corners blocker = level({0.2, 0.7}, {0.1, 0.6}, 0.4);
  const Approximation one = formFactorPastBlocker(floorSquare(), ceilingSquare(), blocker);
  const Approximation other = formFactorPastBlocker(floorSquare(), ceilingSquare(), test::flipped(blocker));
  EXPECT_TRUE(isGood(one, other.value, other.error));
}

// Every line from floor to ceiling crosses the middle level in exactly one of 9 tiles, so the losses behind them add up
// to the whole.
TEST(PastBlocker, WhatTheTilesOfALevelHideAddsUp) {
  const double ends[] = {-0.5, 0.3, 0.45, 1.5};
  const double open = parallelRectangles(kSide, kSide, kSide, kSide, 1);
  double hidden = 0, error = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Approximation seen = formFactorPastBlocker(floorSquare(), ceilingSquare(),
                                                       level({ends[i], ends[i + 1]}, {ends[j], ends[j + 1]}, 0.5));
      EXPECT_LE(seen.error, kPastBlockerError);
      hidden += open - seen.value;
      error += seen.error;
    }
  EXPECT_TRUE(isWithin(hidden, open, error + 1e-14));
}

TEST(PastBlocker, HalfALevelHidesHalfBySymmetry) {
  const Approximation seen = formFactorPastBlocker(floorSquare(), ceilingSquare(), level({-3, 0.5}, {-3, 4}, 0.5));
  EXPECT_TRUE(isGood(seen, 0.1998248957 / 2, 5e-11));
}

// The blocker touches the ceiling. The part of the ceiling that it covers drops out.
TEST(PastBlocker, BlockerWithinThePlaneOfB) {
  const double covered = parallelRectangles(kSide, kSide, {0.2, 0.7}, {0.5, 1}, 1),
               open = parallelRectangles(kSide, kSide, kSide, kSide, 1);
  EXPECT_TRUE(
      isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), level({0.2, 0.7}, {0.5, 1.5}, 1)), open - covered));
}

TEST(PastBlocker, BlockerBehindEitherOrWithinThePlaneOfAStopsNothing) {
  for (double z : {-0.5, 0.0, 1.5})
    EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), level({0.2, 0.7}, {0.2, 0.7}, z)),
                       0.1998248957, 5e-11))
        << z;
}

// A blocker just above the floor covers the part of the floor below it. Light enters at its rim, from a strip as wide
// as the gap. This changes the result by O(gap).
TEST(PastBlocker, BlockerJustAboveACoversIt) {
  const double gap = 1e-9, rest = parallelRectangles({0.4, 1}, kSide, kSide, kSide, 1);
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), level({-1, 0.4}, {-1, 2}, gap)), 0.6 * rest,
                     kContourError + 20 * gap));
}

// A partition reaches from below the floor to above the ceiling. Each half of the floor sees only the opposite half of
// the ceiling.
TEST(PastBlocker, PartitionThroughBoth) {
  for (double x : {0.5, 0.3}) {
    const Interval left{0, x}, right{x, 1};
    const double truth = x * parallelRectangles(left, kSide, left, kSide, 1) +
                         (1 - x) * parallelRectangles(right, kSide, right, kSide, 1);
    const Corners partition = rectangle({x, -20, -1}, {0, 41, 0}, {0, 0, 3});
    EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), ceilingSquare(), partition), truth)) << x;
  }
}

// The partition stands on the floor. It hides the wall from the far half of the floor, and nothing from the near half.
TEST(PastBlocker, PartitionHidesTheWallFromTheFarFloor) {
  const Corners partition = rectangle({0.5, -20, 0}, {0, 41, 0}, {0, 0, 40});
  const double truth = 0.5 * perpendicularRectangles({0, 0.5}, kSide, kSide, kSide);
  EXPECT_TRUE(isGood(formFactorPastBlocker(floorSquare(), wallSquare(), partition), truth));
}

TEST(PastBlocker, RandomTriplesReciprocal) {
  test::Random random(32);
  int hidden_in_part = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const auto [a, b] = test::randomPair(random);
    const Corners blocker = random.convexPolygon(0.4 * b[0] + 0.2 * random.direction(), random.direction(), 4);
    const Approximation ab = formFactorPastBlocker(a, b, blocker), ba = formFactorPastBlocker(b, a, blocker);
    EXPECT_TRUE(
        isWithin(areaOf(a) * ab.value, areaOf(b) * ba.value, areaOf(a) * ab.error + areaOf(b) * ba.error + 1e-14))
        << "trial " << trial;
    const double open = formFactor(a, b);
    EXPECT_LE(ab.value, open + ab.error) << "trial " << trial;
    hidden_in_part += ab.value > 1e-3 && ab.value < 0.98 * open;
  }
  EXPECT_GE(hidden_in_part, 4);
}

// A blocker just above a casts a thin half shadow on a, but none on b. So integrating over b is an independent check.
TEST(PastBlocker, ThinGapsReciprocal) {
  for (double gap : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-12}) {
    const Corners flap = rectangle({0, 0, 0}, {0, 1, 0}, {0.5, 0, gap}), low = level({0.3, 0.7}, {0.3, 0.7}, gap),
                  standing = rectangle({0.3, 0.3, gap}, {0, 0.4, 0}, {0, 0, 0.3});
    for (const Corners& blocker : {flap, low, standing})
      for (const Corners& b : {wallSquare(), ceilingSquare()}) {
        const Approximation there = formFactorPastBlocker(floorSquare(), b, blocker),
                            back = formFactorPastBlocker(b, floorSquare(), blocker);
        EXPECT_TRUE(isGood(there, back.value, back.error)) << "gap " << gap;
      }
  }
}

bool isOver(const Corners& polygon, glm::dvec3 origin, glm::dvec3 direction, double longest) {
  const glm::dvec3 normal = glm::cross(polygon[1] - polygon[0], polygon[2] - polygon[0]);
  const double t = glm::dot(normal, polygon[0] - origin) / glm::dot(normal, direction);
  if (!(t > 0 && t < longest)) return false;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const glm::dvec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    if (glm::dot(glm::cross(q - p, origin + t * direction - p), normal) < 0) return false;
  }
  return true;
}

// Rays start at uniform points of a, with directions of Lambert's cosine law. The 8 comparisons allow 4.5 standard
// errors, so one choice of the seed in 18,000 raises a false alarm.
TEST(PastBlocker, RandomTriplesAgreeWithRays) {
  test::Random random(33);
  int hidden_in_part = 0;
  for (int trial = 0; trial < 8; ++trial) {
    const glm::dvec3 towards = random.direction();
    const Corners a = random.convexPolygon({0, 0, 0}, glm::normalize(towards + 0.3 * random.direction()), 3);
    const Corners b = random.convexPolygon(1.5 * towards, glm::normalize(-towards + 0.3 * random.direction()), 5);
    const Corners blocker = random.convexPolygon(0.8 * towards + 0.4 * random.direction(), random.direction(), 4);
    const glm::dvec3 normal = glm::normalize(glm::cross(a[1] - a[0], a[2] - a[0])), x = glm::normalize(a[1] - a[0]),
                     y = glm::cross(normal, x);
    const glm::dvec3 back = glm::cross(b[1] - b[0], b[2] - b[0]);
    constexpr int kRays = 400'000;
    int hits = 0;
    for (int ray = 0; ray < kRays; ++ray) {
      const double s = std::sqrt(random.uniform()), t = random.uniform(), r = std::sqrt(random.uniform()),
                   angle_rad = random.uniform(0, 2 * std::numbers::pi);
      const glm::dvec3 origin = a[0] + s * ((1 - t) * (a[1] - a[0]) + t * (a[2] - a[0]));
      const glm::dvec3 u = r * std::cos(angle_rad) * x + r * std::sin(angle_rad) * y + std::sqrt(1 - r * r) * normal;
      if (glm::dot(back, u) >= 0 || !isOver(b, origin, u, 1e9)) continue;
      hits += !isOver(blocker, origin, u, glm::dot(back, b[0] - origin) / glm::dot(back, u));
    }
    const double share = hits / (double)kRays, standard_error = std::sqrt(share * (1 - share) / kRays);
    const Approximation seen = formFactorPastBlocker(a, b, blocker);
    EXPECT_TRUE(test::isEstimateOf(share, standard_error, seen.value, seen.error)) << "trial " << trial << ", seed 33";
    hidden_in_part += seen.value > 0.01 && seen.value < 0.9 * formFactor(a, b);
  }
  EXPECT_GE(hidden_in_part, 3);
}

TEST(PastBlocker, RefusesBadPolygons) {
  EXPECT_THROW(formFactorPastBlocker(floorSquare(), ceilingSquare(), Corners{{0, 0, 0}, {1, 0, 0}}), Error);
}

}  // namespace
}  // namespace viewpeel::reference
