#include "reference/closed_forms/rectangles.h"

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

using test::isWithin;
using test::rectangle;

constexpr Interval kUnit{0, 1};
constexpr double kTenDigits = 5e-11;

double contour(Interval x, Interval y, Interval xi, Interval eta, double z) {
  return formFactor(rectangle({x.low, y.low, 0}, {x.high - x.low, 0, 0}, {0, y.high - y.low, 0}),
                    rectangle({xi.low, eta.low, z}, {0, eta.high - eta.low, 0}, {xi.high - xi.low, 0, 0}));
}

double contourPerpendicular(Interval x, Interval y, Interval eta, Interval zeta) {
  return formFactor(rectangle({x.low, y.low, 0}, {x.high - x.low, 0, 0}, {0, y.high - y.low, 0}),
                    rectangle({0, eta.low, zeta.low}, {0, eta.high - eta.low, 0}, {0, 0, zeta.high - zeta.low}));
}

Interval randomInterval(test::Random& random, double low, double high) {
  const double a = random.uniform(low, high), b = random.uniform(low, high);
  return a < b ? Interval{a, b + 0.05} : Interval{b, a + 0.05};
}

// The contour integral takes corners that are rounded sums: 4 corners are off by 2^-52 of coordinates of at most 4.
constexpr double kBound = kContourError + 64 * 0x1p-52;

// The values are C-11 and C-14 of Howell's catalogue.
TEST(Rectangles, PublishedValues) {
  EXPECT_TRUE(isWithin(parallelRectangles(kUnit, kUnit, kUnit, kUnit, 1), 0.1998248957, kTenDigits));
  EXPECT_TRUE(isWithin(perpendicularRectangles(kUnit, kUnit, kUnit, kUnit), 0.2000437761, kTenDigits));
}

TEST(Rectangles, SixFacesOfTheCubeClose) {
  const double sum =
      parallelRectangles(kUnit, kUnit, kUnit, kUnit, 1) + 4 * perpendicularRectangles(kUnit, kUnit, kUnit, kUnit);
  EXPECT_TRUE(isWithin(sum, 1, 1e-15));
}

TEST(Rectangles, RandomParallelAgreesWithContourIntegral) {
  test::Random random(2);
  for (int trial = 0; trial < 60; ++trial) {
    const Interval x = randomInterval(random, -1, 1), y = randomInterval(random, -1, 1),
                   xi = randomInterval(random, -2, 2), eta = randomInterval(random, -2, 2);
    const double z = std::pow(10, random.uniform(-3, 0.5));
    EXPECT_TRUE(isWithin(parallelRectangles(x, y, xi, eta, z), contour(x, y, xi, eta, z), kBound)) << "trial " << trial;
  }
}

TEST(Rectangles, RandomPerpendicularAgreesWithContourIntegral) {
  test::Random random(3);
  for (int trial = 0; trial < 60; ++trial) {
    Interval x = randomInterval(random, 0, 2), y = randomInterval(random, -1, 1), eta = randomInterval(random, -2, 2),
             zeta = randomInterval(random, 0, 2);
    if (trial % 3 == 0) x.low = 0;
    if (trial % 3 == 0 || trial % 5 == 0) zeta.low = 0;
    if (trial % 2) eta = y;
    EXPECT_TRUE(isWithin(perpendicularRectangles(x, y, eta, zeta), contourPerpendicular(x, y, eta, zeta), kBound))
        << "trial " << trial;
  }
}

TEST(Rectangles, Reciprocity) {
  const Interval x{0, 2}, y{0, 1}, xi{1, 4}, eta{-3, 5};
  EXPECT_TRUE(isWithin(2 * parallelRectangles(x, y, xi, eta, 0.5), 24 * parallelRectangles(xi, eta, x, y, 0.5), 1e-15));
  EXPECT_TRUE(isWithin(2 * perpendicularRectangles(x, y, eta, xi), 24 * perpendicularRectangles(xi, eta, y, x), 1e-15));
}

// Far unit squares have the alternating series 1 / (pi z^2) (1 - 2 m2 / z^2 + 3 m4 / z^4 - ...). The mean square offset
// m2 is 1/3, and the mean fourth power m4 is at most 4.
TEST(Rectangles, FarSquaresToTheStatedError) {
  for (double z : {30.0, 100.0, 300.0}) {
    const double leading = (1 - 2 / (3 * z * z)) / (std::numbers::pi * z * z);
    const double e = 0x1p-63, r2 = z * z + 2;
    EXPECT_TRUE(isWithin(parallelRectangles(kUnit, kUnit, kUnit, kUnit, z), leading,
                         leading * 12 / std::pow(z, 4) + 64 * e * r2))
        << z;
  }
}

TEST(Rectangles, RefusesEmptyAndHidden) {
  EXPECT_THROW(parallelRectangles({1, 1}, kUnit, kUnit, kUnit, 1), Error);
  EXPECT_THROW(parallelRectangles(kUnit, kUnit, kUnit, kUnit, 0), Error);
  EXPECT_THROW(perpendicularRectangles({-1, 1}, kUnit, kUnit, kUnit), Error);
  EXPECT_THROW(perpendicularRectangles(kUnit, kUnit, kUnit, {-1, 1}), Error);
}

}  // namespace
}  // namespace viewpeel::reference
