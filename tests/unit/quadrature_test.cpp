#include "reference/closed_forms/quadrature.h"

#include <cmath>
#include <limits>

#include "tests/support/reference_shapes.h"

namespace viewpeel::reference {
namespace {

constexpr long double kUlp = std::numeric_limits<long double>::epsilon();

TEST(GaussRule, ExactForMonomialsUpToItsDegree) {
  for (int n : {1, 2, 3, 8, 16, 64})
    for (int degree = 0; degree < 2 * n; ++degree) {
      const GaussRule& rule = gaussRule(n);
      long double sum = 0;
      for (int k = 0; k < n; ++k) sum += rule.weights[k] * std::pow(rule.nodes[k], (long double)degree);
      // Weights and nodes are off by up to 4 ulp, and the error of a node counts `degree` times.
      EXPECT_LE(std::abs(sum * (degree + 1) - 1), 4 * (degree + 2) * kUlp) << n << " points, degree " << degree;
    }
}

TEST(GaussRule, NotExactOneDegreeHigher) {
  const GaussRule& rule = gaussRule(2);
  EXPECT_GT(std::abs(rule.weights[0] * std::pow(rule.nodes[0], 4.0L) + rule.weights[1] * std::pow(rule.nodes[1], 4.0L) -
                     0.2L),
            1e-3L);
}

TEST(Integrate, EndSingularityWithinItsError) {
  const LineIntegral i = integrate([](long double x) { return x * std::log(x); }, 0, 1, 1e-15L);
  EXPECT_LE(std::abs(i.value + 0.25L), i.error);
  EXPECT_LE(i.error, 1e-15L);
}

TEST(Integrate, NearSingularityWithinItsError) {
  for (long double d : {1e-3L, 1e-8L, 1e-15L}) {
    const LineIntegral i = integrate([d](long double x) { return std::log(std::hypot(x, d)); }, 0, 1, 1e-14L);
    const long double truth = std::log(std::hypot(1.0L, d)) - 1 + d * std::atan(1 / d);
    EXPECT_LE(std::abs(i.value - truth), i.error) << (double)d;
    EXPECT_LE(i.error, 2e-14L) << (double)d;
  }
}

TEST(Integrate, SaysSoWhereItStops) {
  // 1/x is not integrable. After 60 halvings the reported error is as large as the last change of the value.
  EXPECT_GT(integrate([](long double x) { return 1 / x; }, 0, 1, 1e-15L).error, 1e-3L);
}

// Halving cannot resolve an integrand that is all rounding. The integration must end all the same, and report the
// error. With the size of the noise given it ends after the rules of 10 and 16 points on the first interval.
TEST(Integrate, EndsAtTheNoise) {
  int calls = 0;
  const auto noisy = [&calls](long double x) { return ++calls, 1e-18L * std::sin(1e20L * x); };
  const LineIntegral integral = integrate(noisy, 0, 1, 1e-25L, 1e-18L);
  EXPECT_EQ(calls, 26);
  EXPECT_GE(integral.error, 1e-19L);
  const LineIntegral unresolved = integrate(noisy, 0, 1, 1e-25L);
  EXPECT_LE(calls, 3'000'000);
  EXPECT_GE(unresolved.error, 1e-20L);
}

TEST(Integrate, EmptyInterval) {
  EXPECT_EQ(integrate([](long double) { return 1.0L; }, 1, 1, 0).value, 0);
}

}  // namespace
}  // namespace viewpeel::reference
