#include "estimator/chernoff.h"

#include <algorithm>
#include <cmath>

namespace viewpeel {
namespace {

constexpr double kWidth = 1e-10;

double divergence(double x, double y) {
  const double with = x > 0 ? x * std::log(x / y) : 0, without = x < 1 ? (1 - x) * std::log((1 - x) / (1 - y)) : 0;
  return with + without;
}

// Returns the largest expectation mu above the observed mean with n KL(mean, mu) <= l, as in chernoff.h.
double upperBound(double mean, double n, double l) {
  if (mean >= 1) return 1;
  if (mean <= 0) return -std::expm1(-l / n);
  // Pinsker's inequality, n KL >= 2 n (mu - mean)^2, bounds the search from above.
  double low = mean, high = std::min(1.0, mean + std::sqrt(l / (2 * n)));
  while (high - low > kWidth) {
    const double middle = (low + high) / 2;
    (n * divergence(mean, middle) <= l ? low : high) = middle;
  }
  return high;
}

}  // namespace

MeanBounds chernoffBounds(double mean_low, double mean_high, double n, double l) {
  return {1 - upperBound(1 - mean_low, n, l), upperBound(mean_high, n, l)};
}

}  // namespace viewpeel
