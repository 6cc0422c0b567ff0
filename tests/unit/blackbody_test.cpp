// These tests compare shares of black emission with tables and with quadrature.
#include <cmath>

#include <boost/math/quadrature/exp_sinh.hpp>
#include <gtest/gtest.h>

#include <viewpeel/solve.h>
#include "solve/blackbody.h"
#include "tests/support/reference_shapes.h"

namespace viewpeel {
namespace {

using reference::test::isWithin;

// The table is M. F. Modest's, Radiative Heat Transfer, appendix C, with five digits after the point.
TEST(Blackbody, SharesAreThoseOfTables) {
  const struct {
    double um_K, share;
  } table[] = {{1000, 0.00032}, {2000, 0.06673}, {3000, 0.27323},  {4000, 0.48087}, {5000, 0.63373},
               {6000, 0.73779}, {8000, 0.85625}, {10000, 0.91416}, {20000, 0.98555}};
  for (const auto& line : table) {
    EXPECT_TRUE(isWithin(blackbodyShare(line.um_K), line.share, 6e-6)) << line.um_K;
    EXPECT_FALSE(isWithin(blackbodyShare(1.01 * line.um_K), line.share, 6e-6)) << line.um_K;
  }
  EXPECT_EQ(blackbodyShare(0), 0);
  EXPECT_EQ(blackbodyShare(INFINITY), 1);
}

// The quadrature states an error below 1e-13.
TEST(Blackbody, SharesAreIntegrals) {
  const double constant = 14387.768775039337, scale = 15 / std::pow(std::acos(-1.0), 4);
  boost::math::quadrature::exp_sinh<double> rule;
  for (const double z : {0.01, 0.3, 1.0, 1.999, 2.0, 2.001, 5.0, 20.0, 60.0}) {
    const double truth =
        scale * rule.integrate([](double x) { return x > 700 ? 0.0 : x * x * x / std::expm1(x); }, z, INFINITY, 1e-14);
    EXPECT_TRUE(isWithin(blackbodyShare(constant / z), truth, 1e-13)) << z;
    EXPECT_FALSE(isWithin(blackbodyShare(constant / z * (1 + 1e-6)), truth, 1e-13 * truth)) << z;
  }
}

TEST(Blackbody, BandsAddUpAndSlopesAreDifferences) {
  for (const double temperature : {3.0, 80.0, 300.0, 1500.0, 6000.0}) {
    const Band bands[] = {{0, 2.5}, {2.5, 7}, {7, INFINITY}};
    double power = 0, slope = 0;
    for (const Band& band : bands) {
      power += bandPower(band, temperature);
      slope += bandPowerSlope(band, temperature);
      // Central differences err by h^2 / 6 of the third derivative, 1e-7 of the slope here, and by rounding.
      const double step = 1e-4 * temperature, whole = kStefanBoltzmann * std::pow(temperature, 4);
      const double difference =
          (bandPower(band, temperature + step) - bandPower(band, temperature - step)) / (2 * step);
      EXPECT_TRUE(
          isWithin(bandPowerSlope(band, temperature), difference, 1e-5 * std::abs(difference) + 1e-11 * whole / step))
          << temperature;
    }
    const double whole = kStefanBoltzmann * std::pow(temperature, 4);
    EXPECT_TRUE(isWithin(power, whole, 1e-13 * whole));
    EXPECT_TRUE(isWithin(slope, 4 * whole / temperature, 1e-12 * whole / temperature));
  }
  EXPECT_EQ(bandPower({0, INFINITY}, 0), 0);
  EXPECT_EQ(bandPowerSlope({2, 5}, 0), 0);
}

}  // namespace
}  // namespace viewpeel
