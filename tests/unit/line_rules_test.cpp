// These tests compare the quadrature rules for line integrals of unoccluded form factors with adaptive integration.
#include "unoccluded/line_rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "reference/exact/convex_polygon.h"
#include "reference/closed_forms/quadrature.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

using reference::Vec3;
using reference::test::Random;

TEST(Gauss, IntegratesMonomials) {
  for (int n : {1, 2, 5, 24, 96, 128}) {
    const std::vector<GaussPoint> points = gaussPoints(n);
    for (int k = 0; k < 2 * n; ++k) {
      long double sum = 0;
      for (const GaussPoint& point : points) sum += point.weight * std::pow(point.node, k);
      EXPECT_LE(std::abs(sum - (k % 2 ? 0 : 2.0L / (k + 1))), n * 0x1p-62L) << n << " points, power " << k;
    }
  }
}

TEST(Gauss, LargestMonomialErrorIsFirstOrSeen) {
  // The two-point rule at +-1/sqrt 3 has errors 1/5 - 1/9 on x^4 and 1/7 - 1/27 on x^6.
  EXPECT_NEAR(largestMonomialError(2), 1.0 / 7 - 1.0 / 27, 1e-15);
}

// Piece is the segment q of (38) in docs/method.md; p is the x axis from 0 to 1. inner() is the integral over q from x.
struct Piece {
  Vec3 start, end;

  long double inner(long double x) const {
    const Vec3 along = end - start, from = Vec3(x, 0, 0) - start;
    const long double length = glm::length(along), v = glm::dot(from, along) / length, rest = length - v;
    const long double d = glm::length(glm::cross(from, along)) / length;
    const auto part = [d](long double w) { return w * w + d * d > 0 ? w / 2 * std::log(w * w + d * d) : 0; };
    return part(v) + part(rest) + d * std::atan2(d * length, d * d - v * rest);
  }
  long double length() const { return glm::length(end - start); }
};

long double sumOf(const std::vector<GaussPoint>& points, const Piece& q) {
  long double sum = 0;
  for (const GaussPoint& point : points) sum += (long double)double(point.weight) * q.inner(double(point.node));
  return sum;
}

// Returns the rounding of a sum, per length of q as unoccluded_line.comp adds it. Nodes and weights are doubles.
double roundingOf(const std::vector<GaussPoint>& points, const Piece& q) {
  long double greatest = 0;
  for (const GaussPoint& point : points) greatest = std::max(greatest, std::abs(q.inner(point.node)));
  return 2.2e-16 * double(greatest / q.length());
}

// Returns a random segment at least as long as p. Its distance from the start of p, or from a place up to e before it,
// is log-uniform from 1e-9 to `most`.
Piece randomPiece(Random& random, double most) {
  const double distance = std::exp(random.uniform(std::log(1e-9), std::log(most))),
               beyond = random.uniform() < 0.5 ? std::exp(random.uniform(-20, 1)) : 0;
  const glm::dvec3 side = glm::normalize(glm::cross(random.direction(), {1, 0, 0})),
                   foot = glm::dvec3(-beyond, 0, 0) + distance * side;
  const bool passes = random.uniform() < 0.5;  // the segment passes the nearest point or begins there
  glm::dvec3 along = random.direction();
  if (passes) along -= side * glm::dot(side, along);
  along = glm::normalize(along) * std::exp(random.uniform(0, 4));
  const glm::dvec3 start = foot - along * (passes ? random.uniform() : 0.0);
  return {Vec3(start), Vec3(start + along)};
}

// Returns whether the inner integral is singular at a point between the ends of p.
bool needsCut(const Piece& q) {
  const auto isInside = [](long double x) { return x > 0 && x < 1; };
  if (isInside(q.start.x) || isInside(q.end.x)) return true;
  const Vec3 u = (q.end - q.start) / q.length();
  const long double sine2 = 1 - u.x * u.x, s = (q.start.x - u.x * glm::dot(q.start, u)) / sine2,
                    foot = s * u.x - glm::dot(q.start, u);
  return sine2 > 1e-20L && isInside(s) && foot > 0 && foot < q.length();
}

long double truthOf(const Piece& q) {
  return reference::integrate([&q](long double x) { return q.inner(x); }, 0, 1, 1e-19L * q.length(),
                              1e-19L * q.length())
      .value;
}

TEST(LineRules, GradedErrorIsBoundedWhereverTheSingularityLies) {
  constexpr uint64_t kSeed = 51;
  Random random(kSeed);
  std::array<double, kLineRounds.size()> worst{};
  int tried = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const Piece q = randomPiece(random, 2);
    if (needsCut(q)) continue;
    ++tried;
    const long double truth = truthOf(q);
    for (size_t round = 0; round < kLineRounds.size(); ++round) {
      const std::vector<GaussPoint> points = gradedPoints(int(kLineRounds[round].points[3]));
      const double error = double(std::abs(sumOf(points, q) - truth) / q.length()), rounding = roundingOf(points, q);
      worst[round] = std::max(worst[round], (error - rounding) / kLineRounds[round].graded_error);
      EXPECT_LE(error, kLineRounds[round].graded_error + rounding)
          << "seed " << kSeed << ", trial " << trial << ", round " << round;
    }
  }
  EXPECT_GT(tried, 2000);
  EXPECT_GT(worst[0], 0.3);                          // the bound is not far too wide
  for (double share : worst) EXPECT_LT(share, 0.7);  // the share that line_rules.h states
}

TEST(LineRules, PlainErrorIsBoundedByTheEllipse) {
  constexpr uint64_t kSeed = 52;
  constexpr std::array kClear = {12.0, 3.5, 1.5, 1.5};
  Random random(kSeed);
  std::array<double, 3> worst{};
  for (int trial = 0; trial < 4000; ++trial) {
    const int rule = trial % 3;
    // No segment may enter the sphere around the middle of p. This segment touches it, or begins on it.
    const double clear = kClear[rule] * std::exp(random.uniform(0, 0.5));
    const glm::dvec3 out = random.direction(), nearest = glm::dvec3(0.5, 0, 0) + 0.5 * clear * out;
    const glm::dvec3 along = glm::normalize(glm::cross(out, random.direction())) * std::exp(random.uniform(0, 3));
    const glm::dvec3 start = nearest - along * (random.uniform() < 0.5 ? random.uniform() : 0.0);
    const Piece q{Vec3(start), Vec3(start + along)};
    const long double truth = truthOf(q);
    for (const LineRound& round : kLineRounds) {
      const int n = int(round.points[rule]);
      const double bound = 4 * std::pow(clear + std::sqrt(clear * clear - 1), -2 * n);
      const double error = double(std::abs(sumOf(unitPoints(n), q) - truth) / q.length()),
                   rounding = roundingOf(unitPoints(n), q);
      worst[rule] = std::max(worst[rule], (error - rounding) / bound);
      EXPECT_LE(error, bound + rounding) << "seed " << kSeed << ", trial " << trial << ", " << n << " points, clear "
                                         << clear;
    }
  }
  for (double share : worst) EXPECT_LT(share, 0.7);
}

}  // namespace
}  // namespace viewpeel
