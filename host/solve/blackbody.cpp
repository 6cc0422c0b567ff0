#include "solve/blackbody.h"

#include <array>
#include <cmath>
#include <numbers>

#include <viewpeel/solve.h>

namespace viewpeel {
namespace {

constexpr double kSecondConstant = 14387.768775039337;  // um K: h c / k with the constants of the SI of 2019
constexpr double kShareOfIntegral = 15 / (std::numbers::pi * std::numbers::pi * std::numbers::pi * std::numbers::pi);
constexpr double kSeriesMeet = 2;     // value of z up to which the power series is used
constexpr double kNoEmission = 700;   // above this z, e^-z is 0 in double precision
constexpr double kLeastTerm = 1e-17;  // a series ends at a term of this share of the sum

// Returns the integral of x^3 / (e^x - 1) from z on: the sum of e^-nz (z^3 / n + 3 z^2 / n^2 + 6 z / n^3 + 6 / n^4).
double integralBeyond(double z) {
  double sum = 0;
  for (int n = 1;; ++n) {
    const double k = n, term = std::exp(-k * z) * (((z + 3 / k) * z + 6 / (k * k)) * z + 6 / (k * k * k)) / k;
    sum += term;
    if (term <= kLeastTerm * sum) return sum;
  }
}

// Returns the integral of x^3 / (e^x - 1) from 0 to z. The integrand is x^2 times the sum of B_n x^n / n!, with
// Bernoulli's numbers B_n, and is integrated term by term.
double integralUpTo(double z) {
  // B_2m / (2m)! = -2 (-1)^m zeta(2m) / (2 pi)^2m. From 2m = 54 on zeta is 1 to 1e-16.
  double sum = 1.0 / 3 - z / 8;
  const double turn = 4 * std::numbers::pi * std::numbers::pi;
  double power = 1;
  for (int m = 1;; ++m) {
    power *= -z * z / turn;
    const double term = -2 * std::riemann_zeta(2.0 * m) * power / (2 * m + 3);
    sum += term;
    if (std::abs(term) <= kLeastTerm) return sum * z * z * z;
  }
}

// Returns the derivative of blackbodyShare with respect to the logarithm of its argument.
double shareSlope(double um_K) {
  if (!(um_K > 0) || std::isinf(um_K)) return 0;
  const double z = kSecondConstant / um_K;
  return z > kNoEmission ? 0 : kShareOfIntegral * z * z * z * z / std::expm1(z);
}

double shareOf(const Band& band, double temperature) {
  const double low = blackbodyShare(band.low_um * temperature);
  return std::isinf(band.high_um) ? 1 - low : blackbodyShare(band.high_um * temperature) - low;
}

}  // namespace

double blackbodyShare(double um_K) {
  if (!(um_K > 0)) return 0;
  const double z = kSecondConstant / um_K;
  if (z > kNoEmission) return 0;
  return z < kSeriesMeet ? 1 - kShareOfIntegral * integralUpTo(z) : kShareOfIntegral * integralBeyond(z);
}

double bandPower(const Band& band, double temperature) {
  return kStefanBoltzmann * std::pow(temperature, 4) * shareOf(band, temperature);
}

double bandPowerSlope(const Band& band, double temperature) {
  const double share = shareOf(band, temperature);
  const double slope =
      (std::isinf(band.high_um) ? 0 : shareSlope(band.high_um * temperature)) - shareSlope(band.low_um * temperature);
  return kStefanBoltzmann * std::pow(temperature, 3) * (4 * share + slope);
}

}  // namespace viewpeel
