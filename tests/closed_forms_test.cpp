// The closed forms, each against another way to the same number.
#include "reference/closed_forms.h"

#include <cmath>
#include <numbers>
#include <random>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

namespace viewpeel::reference {
namespace {

constexpr double kPi = std::numbers::pi;

Loop rectangle(glm::dvec3 origin, glm::dvec3 a, glm::dvec3 b) { return {origin, origin + a, origin + a + b, origin + b}; }

// The double area integral by a product midpoint rule: good to second order in the cells.
double areaIntegral(const Loop& a, const Loop& b, int cells) {
  const auto grid = [&](const Loop& q, auto use) {
    for (int i = 0; i < cells; ++i)
      for (int j = 0; j < cells; ++j) use(q[0] + (q[1] - q[0]) * ((i + 0.5) / cells) + (q[3] - q[0]) * ((j + 0.5) / cells));
  };
  const glm::dvec3 na = glm::normalize(glm::cross(a[1] - a[0], a[3] - a[0])), nb = glm::normalize(glm::cross(b[1] - b[0], b[3] - b[0]));
  double sum = 0;
  grid(a, [&](const glm::dvec3& p) {
    grid(b, [&](const glm::dvec3& q) {
      const glm::dvec3 r = q - p;
      const double r2 = glm::dot(r, r);
      sum += std::max(0.0, glm::dot(na, r)) * std::max(0.0, -glm::dot(nb, r)) / (kPi * r2 * r2);
    });
  });
  return sum * areaOf(b) / std::pow(double(cells), 4);
}

TEST(Rectangles, KnownValues) {
  EXPECT_NEAR(parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1), 0.1998248957, 5e-11);
  EXPECT_NEAR(perpendicularRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}), 0.2000437761, 5e-11);
  const double together = parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1) + 4 * perpendicularRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1});
  EXPECT_NEAR(together, 1, 1e-14);  // closure of the cube: a few roundings of terms of size 1
}

// Richardson's extrapolation of the midpoint rule, its last step the error allowed.
TEST(Rectangles, AgreeWithTheAreaIntegral) {
  const struct {
    double closed;
    Loop a, b;
  } cases[] = {
      {parallelRectangles({0, 1}, {0, 2}, {0.5, 2}, {-1, 0.5}, 1.3), rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}),
       rectangle({0.5, -1, 1.3}, {0, 1.5, 0}, {1.5, 0, 0})},
      {perpendicularRectangles({0, 1}, {0.5, 2}, {0.3, 2}, {0.4, 1.5}), rectangle({0, 0.5, 0}, {1, 0, 0}, {0, 1.5, 0}),
       rectangle({0.3, 0, 0.4}, {0, 0, 1.1}, {1.7, 0, 0})},
  };
  for (const auto& c : cases) {
    const double coarse = areaIntegral(c.a, c.b, 12), fine = areaIntegral(c.a, c.b, 24), best = fine + (fine - coarse) / 3;
    EXPECT_NEAR(c.closed, best, std::abs(best - fine));
    EXPECT_GT(std::abs(c.closed * 1.02 - best), std::abs(best - fine));  // 2 % would be seen
  }
}

TEST(Discs, LimitsAndAnIndependentIntegral) {
  EXPECT_NEAR(coaxialDiscs(1, 1e-4, 1), 1e-8 / 2, 1e-15);  // a point of area pi 1e-8 sees the disc under 45 degrees: F21 = 1/2
  EXPECT_NEAR(coaxialDiscs(1e-5, 1, 1), 0.5, 1e-9);
  EXPECT_NEAR(coaxialDiscs(1, 1, 1e-6), 1, 3e-6);  // close to 1 - h / r
  EXPECT_NEAR(coaxialDiscs(2, 3, 1.5) * 4, coaxialDiscs(3, 2, 1.5) * 9, 1e-14);
  // Regular polygons inscribed in and circumscribed about the circles bound it from either side for the receiving disc.
  const auto ring = [](double r, double z, int m, bool up) {
    Loop loop;
    for (int k = 0; k < m; ++k) {
      const double t = 2 * kPi * (up ? k : -k) / m;
      loop.push_back({r * std::cos(t), r * std::sin(t), z});
    }
    return loop;
  };
  // Equal areas make the polygons' error second order in 1 / m^2: extrapolated from 24 and 48 sides.
  const auto discs = [&](int m) {
    const double widen = std::sqrt(2 * kPi / (m * std::sin(2 * kPi / m)));
    return polygonToPolygon(ring(0.5 * widen, 0, m, true), ring(0.8 * widen, 1, m, false));
  };
  const double fine = discs(48), coarse = discs(24);
  EXPECT_NEAR(coaxialDiscs(0.5, 0.8, 1), fine, 2 * std::abs(fine - coarse) + 1e-12);
}

TEST(PolygonToPolygon, AgreesWithRectangles) {
  EXPECT_NEAR(polygonToPolygon(rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0})),
              parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, 1), 1e-12);
  // A common edge, whole and in part; a common corner; nearly touching; far.
  for (const auto& [x2, z] : {std::pair<Span, Span>({0, 1}, {0, 1}), {{0.3, 2}, {0, 0.2}}, {{1, 2}, {0, 1}}, {{0, 1}, {1e-7, 1}}, {{0, 1}, {1e-3, 5}}}) {
    const Loop floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const Loop wall = rectangle({x2.low, 0, z.low}, {0, 0, z.high - z.low}, {x2.high - x2.low, 0, 0});
    EXPECT_NEAR(polygonToPolygon(floor, wall), perpendicularRectangles({0, 1}, {0, 1}, x2, z), 1e-10) << x2.low << " " << z.low;
  }
  for (double gap : {1e-1, 1e-3, 1e-6}) {
    const double f = polygonToPolygon(rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, gap}, {0, 1, 0}, {1, 0, 0}));
    EXPECT_NEAR(f, parallelRectangles({0, 1}, {0, 1}, {0, 1}, {0, 1}, gap), 1e-10);
  }
}

// All six faces of a box, of any proportions, see one another: rows add up to 1.
TEST(PolygonToPolygon, RowsOfABoxAddUpToOne) {
  for (const glm::dvec3& size : {glm::dvec3(1, 1, 1), glm::dvec3(1, 2, 0.1), glm::dvec3(1, 1e-3, 1), glm::dvec3(1, 1000, 1)}) {
    std::vector<Loop> faces;
    for (int axis = 0; axis < 3; ++axis)
      for (int upper = 0; upper < 2; ++upper) {
        glm::dvec3 origin(0), a(0), b(0);
        if (upper) origin[axis] = size[axis];
        a[(axis + 1) % 3] = size[(axis + 1) % 3];
        b[(axis + 2) % 3] = size[(axis + 2) % 3];
        faces.push_back(upper ? rectangle(origin, b, a) : rectangle(origin, a, b));
      }
    for (const Loop& from : faces) {
      double row = 0;
      for (const Loop& to : faces)
        if (&to != &from) row += polygonToPolygon(from, to);
      EXPECT_NEAR(row, 1, 5e-10) << size.x << " x " << size.y << " x " << size.z;  // five factors of 1e-10 each
    }
  }
}

Loop randomTriangle(std::mt19937_64& random, glm::dvec3 centre) {
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const auto point = [&] { return centre + glm::dvec3(uniform(random), uniform(random), uniform(random)); };
  return {point(), point(), point()};
}

TEST(PolygonToPolygon, ReciprocityAdditivityAndScale) {
  std::mt19937_64 random(11);
  int seen = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Loop a = randomTriangle(random, {0, 0, 0}), b = randomTriangle(random, {0.3, 0.2, 1.2});
    const double f = polygonToPolygon(a, b);
    seen += f > 1e-6;
    EXPECT_NEAR(f * areaOf(a), polygonToPolygon(b, a) * areaOf(b), 1e-10 * (areaOf(a) + areaOf(b)));
    const glm::dvec3 cut = b[0] * 0.4 + b[1] * 0.6;
    EXPECT_NEAR(f, polygonToPolygon(a, Loop{b[0], cut, b[2]}) + polygonToPolygon(a, Loop{cut, b[1], b[2]}), 3e-10);
    Loop large_a = a, large_b = b;
    for (glm::dvec3& p : large_a) p = p * 1e4 + glm::dvec3(5, 6, 7);
    for (glm::dvec3& p : large_b) p = p * 1e4 + glm::dvec3(5, 6, 7);
    EXPECT_NEAR(f, polygonToPolygon(large_a, large_b), 1e-10);
  }
  EXPECT_GT(seen, 30);
}

// Two squares hinged at an edge: all angles, against Monte Carlo over directions. 4.5 standard errors over 7 angles: false-alarm rate 5e-5.
TEST(PaperEstimator, AgreesWithTheContourIntegral) {
  int rejected = 0;
  for (double angle_deg : {10.0, 30.0, 60.0, 90.0, 120.0, 150.0, 175.0}) {
    const double c = std::cos(angle_deg * kPi / 180), s = std::sin(angle_deg * kPi / 180);
    const Loop a = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), b = rectangle({0, 0, 0}, {0, c, s}, {1, 0, 0});
    const double f = polygonToPolygon(a, b);
    const Estimated e = estimateByProjection(a, b, 40000, 3);
    EXPECT_NEAR(e.value, f, 4.5 * e.standard_error) << angle_deg;
    rejected += std::abs(e.value - f * 1.1) > 4.5 * e.standard_error;
  }
  EXPECT_GE(rejected, 5);  // the comparison sees 10 %
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 20; ++trial) {  // 20 more: 1.4e-4
    const Loop a = randomTriangle(random, {0, 0, 0}), b = randomTriangle(random, {0.2, 0.1, 1});
    const Estimated e = estimateByProjection(a, b, 20000, 4);
    EXPECT_NEAR(e.value, polygonToPolygon(a, b), 4.5 * e.standard_error + 1e-10);
  }
}

TEST(PointToPolygon, KnownValues) {
  // A point below the corner of a parallel rectangle, Howell B-3.
  const double x = 0.7, y = 1.3, z = 0.5, p = std::hypot(x, z), q = std::hypot(y, z);
  const double truth = (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * kPi);
  EXPECT_NEAR(pointToPolygon({0, 0, 0}, {0, 0, 1}, rectangle({0, 0, z}, {0, y, 0}, {x, 0, 0})), truth, 1e-15);
  EXPECT_EQ(pointToPolygon({0, 0, 0}, {0, 0, -1}, rectangle({0, 0, z}, {0, y, 0}, {x, 0, 0})), 0);
}

const Loop kLower = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), kUpper = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});

TEST(PastBlocker, BlockersWithAnObviousEffect) {
  const double open = polygonToPolygon(kLower, kUpper);
  EXPECT_NEAR(polygonPastBlocker(kLower, kUpper, rectangle({3, 3, 0.5}, {1, 0, 0}, {0, 1, 0})), open, 1e-7);       // aside
  EXPECT_NEAR(polygonPastBlocker(kLower, kUpper, rectangle({-0.1, -0.1, 1.5}, {2, 0, 0}, {0, 2, 0})), open, 1e-7);  // behind
  EXPECT_NEAR(polygonPastBlocker(kLower, kUpper, rectangle({-9, -9, 0.5}, {20, 0, 0}, {0, 20, 0})), 0, 1e-7);       // in the way
  // Next to b it hides what it lies on: the rest is a rectangle.
  EXPECT_NEAR(polygonPastBlocker(kLower, kUpper, rectangle({-1, -1, 1 - 1e-9}, {1.4, 0, 0}, {0, 3, 0})),
              parallelRectangles({0, 1}, {0, 1}, {0.4, 1}, {0, 1}, 1), 1e-7 + 1e-8);
  // A wall through the middle, from floor to ceiling: each half sees only its own half.
  const double half = parallelRectangles({0, 0.5}, {0, 1}, {0, 0.5}, {0, 1}, 1);
  EXPECT_NEAR(polygonPastBlocker(kLower, kUpper, rectangle({0.5, -5, 0}, {0, 11, 0}, {0, 0, 1})), half, 1e-7 + 1e-9);
}

// Against lines drawn at random from a, cosine-weighted. 5 standard errors over 8 blockers: false-alarm rate 5e-6.
TEST(PastBlocker, AgreesWithRayShooting) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 8; ++trial) {
    const Loop blocker = randomTriangle(random, {0.5, 0.5, 0.5});
    const glm::dvec3 normal = glm::cross(blocker[1] - blocker[0], blocker[2] - blocker[0]);
    int hits = 0;
    const int shots = 400000;
    for (int k = 0; k < shots; ++k) {
      const glm::dvec3 p(uniform(random), uniform(random), 0);
      const double r = std::sqrt(uniform(random)), t = 2 * kPi * uniform(random);
      const glm::dvec3 d(r * std::cos(t), r * std::sin(t), std::sqrt(1 - r * r));
      const glm::dvec3 q = p + d / d.z;
      if (q.x < 0 || q.x > 1 || q.y < 0 || q.y > 1) continue;
      const double s = glm::dot(blocker[0] - p, normal) / glm::dot(d, normal);
      bool blocked = s > 0 && s < 1 / d.z;
      for (int e = 0; e < 3 && blocked; ++e)
        blocked = glm::dot(glm::cross(blocker[(e + 1) % 3] - blocker[e], p + s * d - blocker[e]), normal) > 0;
      hits += !blocked;
    }
    const double f = double(hits) / shots, standard_error = std::sqrt(f * (1 - f) / shots);
    const double exact = polygonPastBlocker(kLower, kUpper, blocker, 1e-6);
    EXPECT_NEAR(exact, f, 5 * standard_error);
    EXPECT_LT(exact, polygonToPolygon(kLower, kUpper) + 1e-6);
  }
}

}  // namespace
}  // namespace viewpeel::reference
