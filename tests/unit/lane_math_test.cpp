// These tests compare the logarithm and the arc tangent of lanes with long double, with vectors of every width.
#include "unoccluded/lane_math.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "vectorised.h"

namespace viewpeel {
namespace {

struct Values {
  std::vector<double> logs, angles;  // of as many points
};

// Returns ln x, and the angle between (x, y) and the x axis.    In: x, y: numbers for whole lanes
Values evaluate(Vectors vectors, const std::vector<double>& x, const std::vector<double>& y) {
  Values values{std::vector<double>(x.size()), std::vector<double>(x.size())};
  runInLanes(
      vectors, [&](auto types) __attribute__((always_inline)) {
        using Doubles = typename decltype(types)::Doubles;
        for (size_t k = 0; k < x.size(); k += kBlockerLanes) {
          const auto of_x = load<Doubles>(&x[k]), of_y = load<Doubles>(&y[k]);
          store(logOf(sizeOf(of_x)), &values.logs[k]);
          store(angleOf(of_x, of_y), &values.angles[k]);
        }
      });
  return values;
}

double ulpOf(long double x) {
  int exponent = 0;
  std::frexp(double(x), &exponent);
  return std::ldexp(1.0, exponent - 53);
}

TEST(LaneMath, LogarithmAndAngleHaveTheErrorsStated) {
  std::mt19937_64 random(71);
  std::vector<double> x{1, -1, 1e-290, 1e-290, 1, -1, 1e-290, 2}, y{0, 0, 0, 1e-290, 1e-290, 1e-290, 1, 0.5};
  const auto add = [&](double x_low, double x_high, double y_low, double y_high) {
    x.push_back(std::uniform_real_distribution(x_low, x_high)(random));
    y.push_back(std::uniform_real_distribution(y_low, y_high)(random));
  };
  for (int k = 0; k < 40'000; ++k) {
    add(0.5, 2, 0, 2);
    add(-2, -0.5, 0, 2);
    add(0.999, 1.001, 0.4, 0.43);  // logarithms near 0; the angle where the series changes
    add(-600, 600, -600, 600);
    x.back() = (k % 2 ? -1 : 1) * std::exp(x.back()), y.back() = std::exp(y.back());
  }
  ASSERT_EQ(x.size() % kBlockerLanes, 0u);
  const Values values = evaluate(Vectors::plain, x, y);
  double worst_log = 0, worst_angle = 0;
  for (size_t k = 0; k < x.size(); ++k) {
    const long double log = std::log(std::abs((long double)x[k])),
                      angle = std::atan2((long double)y[k], (long double)x[k]);
    if (log == 0) EXPECT_EQ(values.logs[k], 0);
    else worst_log = std::max(worst_log, double(std::abs(values.logs[k] - log)) / ulpOf(log));
    if (angle == 0) EXPECT_EQ(values.angles[k], 0) << x[k] << ", " << y[k];
    else if (angle > 1e-290L)
      worst_angle = std::max(worst_angle, double(std::abs(values.angles[k] - angle)) / ulpOf(angle));
  }
  EXPECT_LE(worst_log, 1);
  EXPECT_LE(worst_angle, 3);
  EXPECT_GT(worst_log, 0.4);  // negative control: the functions are not exact
  EXPECT_GT(worst_angle, 0.4);
  for (const Vectors wider : {Vectors::avx2, Vectors::avx512}) {
    if (wider > widestVectors()) continue;
    const Values same = evaluate(wider, x, y);
    EXPECT_EQ(same.logs, values.logs);
    EXPECT_EQ(same.angles, values.angles);
  }
}

}  // namespace
}  // namespace viewpeel
