#include "reference/closed_forms/discs.h"

#include <viewpeel/error.h>
#include "reference/closed_forms/contour_integral.h"
#include "reference/closed_forms/quadrature.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

using test::isWithin;

// Returns the mean of the form factor from a point of the first disc, of radius a, to the second disc. The point is at
// distance r from the axis (Howell's catalogue, section B).
LineIntegral integralOfPoints(double a, double b, double h) {
  return integrate(
      [=](long double r) {
        const long double s = h * h + r * r - (long double)b * b, p = h * h + r * r + (long double)b * b;
        return (1 - s / std::sqrt(p * p - 4 * r * r * b * b)) * r / ((long double)a * a);
      },
      0, a, 1e-16L);
}

TEST(Discs, AgreesWithTheIntegralOfPoints) {
  for (double a : {0.5, 1.0, 3.0})
    for (double b : {0.4, 1.0, 2.0})
      for (double h : {0.05, 1.0, 7.0}) {
        const LineIntegral truth = integralOfPoints(a, b, h);
        EXPECT_TRUE(isWithin(coaxialDiscs(a, b, h), (double)truth.value, (double)truth.error + 32 * 0x1p-52))
            << a << " " << b << " " << h;
      }
}

test::Corners ring(double radius, double z, int corner_count) {
  test::Corners corners;
  for (int k = 0; k < corner_count; ++k) {
    const double angle_rad = 2 * std::numbers::pi * k / corner_count;
    corners.push_back({radius * std::cos(angle_rad), radius * std::sin(angle_rad), z});
  }
  return corners;
}

// The exchange area grows with both regions, so polygons inside and outside the discs bracket it.
TEST(Discs, BetweenInnerAndOuterPolygons) {
  constexpr int kCorners = 32;
  const double a = 1, b = 0.7, h = 0.6, grown = 1 / std::cos(std::numbers::pi / kCorners);
  const auto exchange = [=](double scale) {
    const test::Corners lower = ring(scale * a, 0, kCorners), upper = test::flipped(ring(scale * b, h, kCorners));
    return test::areaOf(lower) * formFactor(lower, upper);
  };
  const double inner = exchange(1), outer = exchange(grown), discs = std::numbers::pi * a * a * coaxialDiscs(a, b, h);
  EXPECT_LT(inner, discs);
  EXPECT_LT(discs, outer);
  EXPECT_LT(outer - inner, 0.03 * discs);
}

// Far away the form factor is b^2 / (h^2 + b^2 + a^2) (1 + O(a^2 b^2 / h^4)). The formula must not lose digits there.
TEST(Discs, FarAndSmallToRelativeError) {
  EXPECT_TRUE(isWithin(coaxialDiscs(1, 1, 1e9) * (1e18 + 2), 1, 32 * 0x1p-52));
  EXPECT_TRUE(isWithin(coaxialDiscs(1, 1e-9, 1) * 2e18, 1, 32 * 0x1p-52));
}

// At a small distance h discs of radius 1 miss the share h of each other's radiation, which leaves at the rim.
TEST(Discs, CloseDiscsSeeEachOtherWhole) { EXPECT_TRUE(isWithin(coaxialDiscs(1, 1, 1e-9), 1, 1.1e-9)); }

TEST(Discs, RefusesWhatIsNotPositive) {
  EXPECT_THROW(coaxialDiscs(1, 1, 0), Error);
  EXPECT_THROW(coaxialDiscs(-1, 1, 1), Error);
  EXPECT_THROW(coaxialDiscs(1, std::nan(""), 1), Error);
}

}  // namespace
}  // namespace viewpeel::reference
