#include "unoccluded/gauss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace viewpeel {

std::vector<GaussPoint> gaussPoints(int n) {
  std::vector<GaussPoint> points(n);
  for (int k = 0; k < n; ++k) {
    long double x = -std::cos(std::numbers::pi_v<long double> * (k + 0.75L) / (n + 0.5L)), slope = 1;
    for (int step = 0; step < 20; ++step) {
      long double p = 1, previous = 0;
      for (int degree = 1; degree <= n; ++degree) {
        const long double next = ((2 * degree - 1) * x * p - (degree - 1) * previous) / degree;
        previous = p;
        p = next;
      }
      slope = n * (x * p - previous) / (x * x - 1);
      const long double correction = p / slope;
      x -= correction;
      if (std::abs(correction) <= std::numeric_limits<long double>::epsilon()) break;
    }
    points[k] = {x, 2 / ((1 - x * x) * slope * slope)};
  }
  return points;
}

double largestMonomialError(int n) {
  // The mean of x^k and the rule's value both decrease with k. Above this power both are smaller than the largest
  // error, so larger powers need not be tried.
  constexpr int kLastPower = 400;
  const std::vector<GaussPoint> points = gaussPoints(n);
  double largest = 0;
  for (int k = 2 * n; k <= kLastPower; k += 2) {
    long double value = 0;
    for (const GaussPoint& point : points) value += point.weight / 2 * std::pow(point.node, k);
    largest = std::max(largest, double(std::abs(1.0L / (k + 1) - value)));
  }
  return largest;
}

}  // namespace viewpeel
