#include "reference/closed_forms/rectangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <viewpeel/error.h>

namespace viewpeel::reference {
namespace {

constexpr long double kTwoPi = 2 * std::numbers::pi_v<long double>;
using Ends = std::array<long double, 2>;

// Returns the ends in units of `scale`, so that the logarithms stay small.
Ends ends(Interval interval, long double scale) { return {interval.low / scale, interval.high / scale}; }

void checkNotEmpty(Interval interval, const char* name) {
  if (!(interval.low < interval.high && std::isfinite(interval.low) && std::isfinite(interval.high)))
    throw Error(ErrorCode::bad_input,
                std::string("rectangle: interval ") + name + " is empty or not finite; give low < high");
}

long double largest(std::initializer_list<Interval> intervals) {
  long double size = 0;
  for (const Interval& i : intervals)
    size = std::max({size, std::abs((long double)i.low), std::abs((long double)i.high)});
  return size;
}

long double area(const Ends& x, const Ends& y) { return (x[1] - x[0]) * (y[1] - y[0]); }

template <class Term>
long double alternatingSum(Term term) {
  long double sum = 0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k)
        for (int l = 0; l < 2; ++l) sum += ((i + j + k + l) % 2 ? -1 : 1) * term(i, j, k, l);
  return sum;
}

long double parallelTerm(long double p, long double q, long double z) {
  const long double a = std::hypot(p, z), b = std::hypot(q, z);
  return (q * a * std::atan(q / a) + p * b * std::atan(p / b) - z * z / 2 * std::log(p * p + q * q + z * z)) / kTwoPi;
}

long double perpendicularTerm(long double c2, long double q) {
  const long double c = std::sqrt(c2), r2 = c2 + q * q;
  return (q * c * std::atan2(q, c) - (r2 > 0 ? (c2 - q * q) / 4 * std::log(r2) : 0)) / kTwoPi;
}

}  // namespace

double parallelRectangles(Interval x, Interval y, Interval xi, Interval eta, double distance) {
  checkNotEmpty(x, "x");
  checkNotEmpty(y, "y");
  checkNotEmpty(xi, "xi");
  checkNotEmpty(eta, "eta");
  if (!(distance > 0 && std::isfinite(distance)))
    throw Error(ErrorCode::bad_input, "parallel rectangles: the distance of the planes must be positive");
  const long double dx = std::max((long double)xi.high - x.low, (long double)x.high - xi.low);
  const long double dy = std::max((long double)eta.high - y.low, (long double)y.high - eta.low);
  const long double scale = std::hypot(std::hypot(dx, dy), distance), z = distance / scale;
  const Ends X = ends(x, scale), Y = ends(y, scale), Xi = ends(xi, scale), Eta = ends(eta, scale);
  return (
      double)(alternatingSum([&](int i, int j, int k, int l) { return parallelTerm(X[i] - Xi[k], Y[j] - Eta[l], z); }) /
              area(X, Y));
}

double perpendicularRectangles(Interval x, Interval y, Interval eta, Interval zeta) {
  checkNotEmpty(x, "x");
  checkNotEmpty(y, "y");
  checkNotEmpty(eta, "eta");
  checkNotEmpty(zeta, "zeta");
  if (x.low < 0 || zeta.low < 0)
    throw Error(ErrorCode::bad_input,
                "perpendicular rectangles: one lies behind the other; clip to x >= 0 and zeta >= 0");
  const long double dy = std::max((long double)eta.high - y.low, (long double)y.high - eta.low);
  const long double scale = std::hypot(largest({x, zeta}), dy);
  const Ends X = ends(x, scale), Y = ends(y, scale), Eta = ends(eta, scale), Zeta = ends(zeta, scale);
  return (double)(alternatingSum([&](int i, int j, int k, int l) {
                    return perpendicularTerm(X[i] * X[i] + Zeta[l] * Zeta[l], Y[j] - Eta[k]);
                  }) /
                  area(X, Y));
}

}  // namespace viewpeel::reference
