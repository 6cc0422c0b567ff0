#include "reference/closed_forms/quadrature.h"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

namespace viewpeel::reference {
namespace {

constexpr int kMaxPoints = 64;
constexpr int kMaxHalvings = 60;
constexpr int kMaxIntervals = 10'000;

// The library's rules (host/unoccluded/gauss.cpp) are made in the same way. This code is separate, because it checks
// results of the library.
GaussRule makeRule(int n) {
  GaussRule rule{std::vector<long double>(n), std::vector<long double>(n)};
  for (int k = 0; k < n; ++k) {
    long double x = std::cos(std::numbers::pi_v<long double> * (k + 0.75L) / (n + 0.5L)), slope = 1;
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
    rule.nodes[k] = (1 - x) / 2;
    rule.weights[k] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

struct Integrator {
  const std::function<long double(long double)>& f;
  const long double noise = 0;
  int interval_count = 0;
  const GaussRule& coarse = gaussRule(10);
  const GaussRule& fine = gaussRule(16);
  LineIntegral total{};

  void add(long double low, long double high, long double tolerance, int depth) {
    const long double width = high - low;
    long double a = 0, b = 0, magnitude = 0;
    for (size_t k = 0; k < coarse.nodes.size(); ++k) a += coarse.weights[k] * f(low + width * coarse.nodes[k]);
    for (size_t k = 0; k < fine.nodes.size(); ++k) {
      const long double term = fine.weights[k] * f(low + width * fine.nodes[k]);
      b += term;
      magnitude += std::abs(term);
    }
    const long double difference = width * std::abs(b - a);
    const long double rounding = width * (16 * std::numeric_limits<long double>::epsilon() * magnitude + 2 * noise);
    if (difference <= tolerance || difference <= rounding || depth == kMaxHalvings ||
        ++interval_count > kMaxIntervals) {
      total.value += width * b;
      total.error += difference + rounding;
      return;
    }
    const long double middle = low + width / 2;
    add(low, middle, tolerance / 2, depth + 1);
    add(middle, high, tolerance / 2, depth + 1);
  }
};

}  // namespace

const GaussRule& gaussRule(int n) {
  assert(n >= 1 && n <= kMaxPoints);
  static std::array<GaussRule, kMaxPoints + 1> rules;
  static std::array<std::once_flag, kMaxPoints + 1> made;
  std::call_once(made[n], [n] { rules[n] = makeRule(n); });
  return rules[n];
}

LineIntegral integrate(const std::function<long double(long double)>& f, long double low, long double high,
                       long double tolerance, long double noise) {
  Integrator integrator{.f = f, .noise = noise};
  if (high > low) integrator.add(low, high, tolerance, 0);
  return integrator.total;
}

}  // namespace viewpeel::reference
