// A Ball is a double with a bound on its rounding error. Decisions try Balls first, and exact arithmetic only where the
// error leaves a doubt.
#pragma once
#include <cmath>

namespace viewpeel::reference {

// A Ball stands for an unknown number within `error` of `value`. kUnit is twice the unit roundoff. The factor of two
// covers the rounding of the errors themselves, which is at most 2^-51 relative per operation.
struct Ball {
  static constexpr double kUnit = 0x1p-52;
  double value = 0;
  double error = 0;
};

inline Ball operator+(Ball a, Ball b) {
  const double sum = a.value + b.value;
  return {sum, a.error + b.error + Ball::kUnit * (std::abs(sum) + a.error + b.error)};
}

inline Ball operator-(Ball a) { return {-a.value, a.error}; }
inline Ball operator-(Ball a, Ball b) { return a + -b; }

inline Ball operator*(Ball a, Ball b) {
  const double product = a.value * b.value;
  const double error = std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error;
  return {product, error + 4 * Ball::kUnit * (std::abs(product) + error) + 0x1p-1000};
}

// Divides. Where b may be 0, the error is infinite.
inline Ball operator/(Ball a, Ball b) {
  const double quotient = a.value / b.value, room = std::abs(b.value) - b.error;
  if (!(room > 0)) return {0, HUGE_VAL};
  const double error = (a.error + std::abs(quotient) * b.error) / room;
  return {quotient, error + 8 * Ball::kUnit * (std::abs(quotient) + error) + 0x1p-1000};
}

// Returns the sign of a if the error leaves no doubt, else 0.
inline int certainSign(Ball a) { return a.value > a.error ? 1 : a.value < -a.error ? -1 : 0; }

}  // namespace viewpeel::reference
