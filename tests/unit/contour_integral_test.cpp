#include "reference/closed_forms/contour_integral.h"

#include <algorithm>
#include <string>

#include <viewpeel/error.h>
#include "reference/closed_forms/quadrature.h"
#include "reference/closed_forms/rectangles.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

using test::areaOf;
using test::Corners;
using test::flipped;
using test::isWithin;
using test::moved;
using test::rectangle;

constexpr Interval kUnit{0, 1};
constexpr double kPi = std::numbers::pi;
// Corners are doubles. Corners that are off by 2^-52 change a form factor of polygons of size 1 by at most this.
constexpr double kCornerRounding = 64 * 0x1p-52;

Corners unitSquare() { return rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}); }
Corners squareAbove(double z, double side = 1) { return rectangle({0, 0, z}, {0, side, 0}, {side, 0, 0}); }

double rowSum(const std::vector<Corners>& faces, size_t i) {
  double sum = 0;
  for (size_t j = 0; j < faces.size(); ++j)
    if (j != i) sum += formFactor(faces[i], faces[j]);
  return sum;
}

void expectCloses(const std::vector<Corners>& faces, const std::string& what) {
  for (size_t i = 0; i < faces.size(); ++i)
    EXPECT_TRUE(isWithin(rowSum(faces, i), 1, (double)(faces.size() - 1) * kContourError + kCornerRounding))
        << what << ", face " << i;
}

// The values are C-11 and C-14 of Howell's catalogue, to ten digits: half a unit of the last digit is 5e-11.
TEST(Contour, PublishedValues) {
  EXPECT_TRUE(isWithin(formFactor(unitSquare(), squareAbove(1)), 0.1998248957, 5e-11));
  const Corners wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  EXPECT_TRUE(isWithin(formFactor(unitSquare(), wall), 0.2000437761, 5e-11));
  EXPECT_FALSE(isWithin(formFactor(unitSquare(), wall), 0.1998248957, 5e-11));
}

TEST(Contour, CubeCloses) { expectCloses(test::boxFaces({1, 1, 1}), "cube"); }

TEST(Contour, RandomBoxesClose) {
  test::Random random(11);
  for (int trial = 0; trial < 6; ++trial) {
    const glm::dvec3 size(std::pow(10, random.uniform(-1, 1)), std::pow(10, random.uniform(-1, 1)), 1);
    expectCloses(test::boxFaces(size), "box of trial " + std::to_string(trial));
  }
}

TEST(Contour, FlatAndLongBoxesClose) {
  for (const glm::dvec3 size : {glm::dvec3(1e3, 1, 1), glm::dvec3(1e3, 1e3, 1), glm::dvec3(1e-3, 1, 30)})
    expectCloses(test::boxFaces(size),
                 "box " + std::to_string(size.x) + " " + std::to_string(size.y) + " " + std::to_string(size.z));
}

TEST(Contour, RandomTetrahedraClose) {
  test::Random random(12);
  for (int trial = 0; trial < 20; ++trial) {
    glm::dvec3 p[4];
    for (glm::dvec3& corner : p) corner = random.uniform(0.5, 1) * random.direction();
    if (glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) < 0) std::swap(p[1], p[2]);
    const double volume = glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    if (volume < 0.05) continue;
    expectCloses({{p[0], p[1], p[2]}, {p[0], p[2], p[3]}, {p[0], p[3], p[1]}, {p[1], p[3], p[2]}},
                 "tetrahedron " + std::to_string(trial));
  }
}

// A wedge is closed by its two sides of width 1, the third side opposite the edge, and two triangles at the ends. All
// of them have edges in common, and every row must sum to 1.
TEST(Contour, WedgesFrom1To179DegreesClose) {
  for (double angle_deg : {1.0, 5.0, 30.0, 60.0, 90.0, 120.0, 150.0, 175.0, 179.0})
    for (double length : {0.5, 20.0}) {
      const double angle_rad = angle_deg * kPi / 180;
      const glm::dvec3 o(0), p(1, 0, 0), q(std::cos(angle_rad), std::sin(angle_rad), 0), z(0, 0, length);
      expectCloses({rectangle(o, z, p), rectangle(o, q, z), rectangle(p, z, q - p), {o, p, q}, {z, q + z, p + z}},
                   "wedge of " + std::to_string(angle_deg) + " degrees, length " + std::to_string(length));
    }
}

// Infinite strips have 1 - sin(angle / 2). The ends lose at most width / length, one width at each end.
TEST(Contour, LongWedgeIsAlmostTheInfiniteStrip) {
  for (double angle_deg : {1.0, 45.0, 90.0, 135.0, 179.0}) {
    const double angle_rad = angle_deg * kPi / 180;
    const glm::dvec3 z(0, 0, 1000), p(1, 0, 0), q(std::cos(angle_rad), std::sin(angle_rad), 0);
    const double strip = 1 - std::sin(angle_rad / 2),
                 value = formFactor(rectangle({0, 0, 0}, z, p), rectangle({0, 0, 0}, q, z));
    EXPECT_LE(value, strip + kContourError) << angle_deg;
    EXPECT_TRUE(isWithin(value, strip, 2 / 1000.0)) << angle_deg;
  }
}

TEST(Contour, RandomPairsReciprocal) {
  test::Random random(13);
  int seen = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const auto [a, b] = test::randomPair(random);
    const double ab = areaOf(a) * formFactor(a, b), ba = areaOf(b) * formFactor(b, a);
    seen += ab > 1e-4;
    EXPECT_TRUE(isWithin(ab, ba, (kContourError + kCornerRounding) * (areaOf(a) + areaOf(b)))) << "trial " << trial;
  }
  EXPECT_GT(seen, 30);
}

TEST(Contour, RandomPairsAddUpOverASplit) {
  test::Random random(14);
  for (int trial = 0; trial < 40; ++trial) {
    const auto [a, b] = test::randomPair(random);
    const glm::dvec3 middle = (b[0] + b[1]) * 0.5;
    const Corners first{b[1], b[2], middle};
    Corners second{middle, b[2]};
    second.insert(second.end(), b.begin() + 3, b.end());
    second.push_back(b[0]);
    EXPECT_TRUE(
        isWithin(formFactor(a, first) + formFactor(a, second), formFactor(a, b), 3 * kContourError + kCornerRounding))
        << "trial " << trial;
  }
}

TEST(Contour, ScaleMotionAndFirstCornerDoNotMatter) {
  test::Random random(15);
  for (int trial = 0; trial < 20; ++trial) {
    const auto [a, b] = test::randomPair(random);
    const double value = formFactor(a, b);
    EXPECT_EQ(formFactor(moved(a, 1024, {}), moved(b, 1024, {})), value) << "trial " << trial;
    const glm::dvec3 by(100, -50, 20);
    EXPECT_TRUE(
        isWithin(formFactor(moved(a, 0.1, by), moved(b, 0.1, by)), value, 2 * kContourError + 2000 * kCornerRounding))
        << "trial " << trial;
    Corners turned = a;
    std::rotate(turned.begin(), turned.begin() + 1, turned.end());
    EXPECT_TRUE(isWithin(formFactor(turned, b), value, 2 * kContourError)) << "trial " << trial;
  }
}

TEST(Contour, BacksAndCoplanarSeeNothing) {
  EXPECT_EQ(formFactor(unitSquare(), flipped(squareAbove(1))), 0);
  EXPECT_EQ(formFactor(flipped(unitSquare()), squareAbove(1)), 0);
  EXPECT_EQ(formFactor(unitSquare(), moved(unitSquare(), 1, {1, 0, 0})), 0);
  EXPECT_EQ(formFactor(unitSquare(), flipped(moved(unitSquare(), 1, {1.5, 0, 0}))), 0);
}

// A wall crosses the middle of the floor. Only the half of the floor in front of the wall and the half of the wall
// above the floor exchange.
TEST(Contour, ClipsWhatReachesBehind) {
  const Corners wall = rectangle({0.5, 0, -1}, {0, 1, 0}, {0, 0, 2});  // looks along +x
  const double half = perpendicularRectangles({0, 0.5}, kUnit, kUnit, kUnit);
  EXPECT_TRUE(isWithin(formFactor(unitSquare(), wall), half / 2, kContourError + kCornerRounding));
  EXPECT_TRUE(isWithin(formFactor(wall, unitSquare()), half / 4, kContourError + kCornerRounding));
}

TEST(Contour, CommonCornerAndEdgeInPart) {
  const Corners corner_wall = rectangle({0, 1, 0}, {0, 1, 0}, {0, 0, 1}),
                part_wall = rectangle({0, 0.25, 0}, {0, 2, 0}, {0, 0, 3});
  EXPECT_TRUE(isWithin(formFactor(unitSquare(), corner_wall), perpendicularRectangles(kUnit, kUnit, {1, 2}, kUnit),
                       kContourError));
  EXPECT_TRUE(isWithin(formFactor(unitSquare(), part_wall), perpendicularRectangles(kUnit, kUnit, {0.25, 2.25}, {0, 3}),
                       kContourError));
}

TEST(Contour, NearTouching) {
  for (double gap : {1e-2, 1e-5, 1e-9, 1e-13}) {
    const Corners wall = rectangle({0, 0, gap}, {0, 1, 0}, {0, 0, 1});
    EXPECT_TRUE(isWithin(formFactor(unitSquare(), wall), perpendicularRectangles(kUnit, kUnit, kUnit, {gap, 1 + gap}),
                         kContourError + kCornerRounding))
        << gap;
    EXPECT_TRUE(isWithin(formFactor(unitSquare(), squareAbove(gap)),
                         parallelRectangles(kUnit, kUnit, kUnit, kUnit, gap), kContourError + kCornerRounding))
        << gap;
  }
}

// Unit squares at distance z have the alternating series 1 / (pi z^2) (1 - 2 m2 / z^2 + 3 m4 / z^4 - ...). The mean
// square m2 of the sideways offset is 1/3, and its mean fourth power m4 is at most 4.
TEST(Contour, FarPairsToRelativeError) {
  for (double z : {1e3, 1e4, 1e6}) {
    const double truth = (1 - 2 / (3 * z * z)) / (kPi * z * z);
    EXPECT_TRUE(
        isWithin(formFactor(unitSquare(), squareAbove(z)), truth, truth * (kFarRelativeError + 12 / std::pow(z, 4))))
        << z;
  }
}

// The rules for near and far pairs meet at a distance of kFarDistance times the sum of the half diagonals, 5.66. Both
// have their accuracy on either side.
TEST(Contour, BothWaysAgreeWhereTheyMeet) {
  for (double z : {5.6, 5.7, 8.0, 16.0}) {
    const double truth = parallelRectangles(kUnit, kUnit, kUnit, kUnit, z);
    EXPECT_TRUE(
        isWithin(formFactor(unitSquare(), squareAbove(z)), truth, z > 5.66 ? kFarRelativeError * truth : kContourError))
        << z;
  }
}

// Returns the form factor from a point to a parallel rectangle, one corner of which is above the point (Howell's
// catalogue, section B).
double pointToCornerRectangle(double x, double y, double z) {
  const double rx = std::hypot(x, z), ry = std::hypot(y, z);
  return (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * kPi);
}

// A small square lies under a large one. The reference is the mean of the form factors from 12 x 12 Gauss points of the
// small square. It is exact to rounding, since the integrand is analytic up to a distance of two sides or more from the
// square.
TEST(Contour, SmallNextToLarge) {
  for (double side : {1e-1, 1e-3, 1e-5, 1e-6}) {
    const Interval small{0.3, 0.3 + side};
    const double width = small.high - small.low, z = 0.2;
    const Corners a = rectangle({small.low, small.low, 0}, {width, 0, 0}, {0, width, 0}), b = squareAbove(z);
    const GaussRule& rule = gaussRule(12);
    double truth = 0;
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) {
        const double x = small.low + width * (double)rule.nodes[i], y = small.low + width * (double)rule.nodes[j];
        truth += (double)(rule.weights[i] * rule.weights[j]) *
                 (pointToCornerRectangle(x, y, z) + pointToCornerRectangle(1 - x, y, z) +
                  pointToCornerRectangle(x, 1 - y, z) + pointToCornerRectangle(1 - x, 1 - y, z));
      }
    EXPECT_TRUE(isWithin(formFactor(a, b), truth, kContourError + kCornerRounding)) << side;
    EXPECT_TRUE(isWithin(formFactor(b, a), truth * areaOf(a), kContourError)) << side;
  }
}

TEST(Contour, RefusesWhatItCannotReach) {
  const Corners speck = rectangle({0.3, 0.3, 0}, {1e-8, 0, 0}, {0, 1e-8, 0});
  EXPECT_THROW(formFactor(speck, squareAbove(1e-2)), Error);
  EXPECT_THROW(formFactor(unitSquare(), Corners{{0, 0, 0}, {1, 0, 0}}), Error);
}

}  // namespace
}  // namespace viewpeel::reference
