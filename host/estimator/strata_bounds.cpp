#include "estimator/strata_bounds.h"

#include <cmath>

#include "estimator/chernoff.h"

namespace viewpeel {
namespace {

constexpr double kRelativeWidth = 1e-6;  // relative width of the interval in which bisection ends

}  // namespace

double boundVariance(const StrataFigures& of, double l) {
  const double most = of.weight * of.weight * of.cells, mean = of.squares / most;
  return most * chernoffBounds(mean, mean, of.cells, l).upper;
}

double bennettDeviation(double variance, double largest, double l) {
  // Bernstein's bound, sqrt(2 v l) + b l / 3, is no smaller (Boucheron, Lugosi, Massart, section 2.8).
  double low = 0, high = std::sqrt(2 * variance * l) + largest * l / 3;
  const double need = l * largest * largest / variance;
  while (high - low > kRelativeWidth * high) {
    const double middle = (low + high) / 2, u = largest * middle / variance;
    ((1 + u) * std::log1p(u) - u <= need ? low : high) = middle;
  }
  return high;
}

double boundDeviation(const StrataFigures& of, double l) {
  return bennettDeviation(boundVariance(of, l), of.weight, l);
}

}  // namespace viewpeel
