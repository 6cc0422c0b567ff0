// Lanes hold a number for each of sixteen lines, or of eight blockers; one vector instruction acts on all. Without
// contraction every lane rounds as a scalar would, so results are the same bits everywhere.
//
// Vulkan devices round sums, differences and products in single precision correctly, quotients and roots to 2.5 ulp or
// worse. Devices must draw the same lines as the processor, so lines are computed by sums, differences, products and
// comparisons alone (docs/method.md, section 13).
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // every function that passes lanes is inlined
#endif

#define VIEWPEEL_INLINE [[gnu::always_inline]] inline

namespace viewpeel {

constexpr int kLineLanes = 16, kBlockerLanes = 8;

using Floats = float __attribute__((vector_size(4 * kLineLanes)));
using Words = uint32_t __attribute__((vector_size(4 * kLineLanes)));
using Integers = int32_t __attribute__((vector_size(4 * kLineLanes)));
using Doubles = double __attribute__((vector_size(8 * kBlockerLanes)));

VIEWPEEL_INLINE Floats all(float x) { return x - Floats{}; }
VIEWPEEL_INLINE Words all(uint32_t x) { return x - Words{}; }
VIEWPEEL_INLINE Doubles all(double x) { return x - Doubles{}; }

template <class Lanes, class Number>
VIEWPEEL_INLINE Lanes load(const Number* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

// A condition is a number for each lane: above 0 means true. Numbers serve better than integers: compilers that do not
// know the processor split comparisons into single lanes where the result is an integer.
VIEWPEEL_INLINE Floats least(const Floats& a, const Floats& b) { return a < b ? a : b; }
VIEWPEEL_INLINE Floats greatest(const Floats& a, const Floats& b) { return a > b ? a : b; }
VIEWPEEL_INLINE Doubles least(const Doubles& a, const Doubles& b) { return a < b ? a : b; }
VIEWPEEL_INLINE Doubles greatest(const Doubles& a, const Doubles& b) { return a > b ? a : b; }

VIEWPEEL_INLINE float least(float a, float b) { return a < b ? a : b; }
VIEWPEEL_INLINE float greatest(float a, float b) { return a > b ? a : b; }
VIEWPEEL_INLINE double least(double a, double b) { return a < b ? a : b; }
VIEWPEEL_INLINE double greatest(double a, double b) { return a > b ? a : b; }

// Returns x where the condition is above 0, else 0.
VIEWPEEL_INLINE Floats keep(const Floats& condition, const Floats& x) { return condition > 0.0f ? x : Floats{}; }

// Returns the largest lane.
VIEWPEEL_INLINE double largestOf(const Doubles& x) {
  const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3], c = x[4] > x[5] ? x[4] : x[5],
               d = x[6] > x[7] ? x[6] : x[7], e = a > b ? a : b, f = c > d ? c : d;
  return e > f ? e : f;
}
VIEWPEEL_INLINE double leastOf(const Doubles& x) { return -largestOf(-x); }

// Returns whether any lane is not 0.
VIEWPEEL_INLINE bool isAny(const Floats& x) {
  uint64_t words[kLineLanes / 2], any = 0;
  std::memcpy(words, &x, sizeof words);
  for (const uint64_t word : words) any |= word;
  return any != 0;
}

// Returns the sum of all lanes. It adds lanes 8 apart first, then 4, 2 and 1, as the shaders do.
VIEWPEEL_INLINE float sumOf(const Floats& x) {
  float sums[kLineLanes];
  std::memcpy(sums, &x, sizeof sums);
  for (int half = kLineLanes / 2; half > 0; half /= 2)
    for (int k = 0; k < half; ++k) sums[k] += sums[k + half];
  return sums[0];
}

VIEWPEEL_INLINE Words bitsOf(const Floats& x) { return (Words)x; }
VIEWPEEL_INLINE uint32_t bitsOf(float x) { return std::bit_cast<uint32_t>(x); }
VIEWPEEL_INLINE Floats numberOf(const Words& bits) { return (Floats)bits; }
VIEWPEEL_INLINE float numberOf(uint32_t bits) { return std::bit_cast<float>(bits); }

// Returns 1 / x for x in [2^-125, 2^125], to 3e-7 of itself. The bits of x make a first guess, and each of Newton's
// steps squares its error.
template <class Numbers>
VIEWPEEL_INLINE Numbers reciprocal(const Numbers& x) {
  Numbers y = numberOf(0x7EF311C7u - bitsOf(x));  // relative error 0.13
  for (int step = 0; step < 3; ++step) y = y * (2.0f - x * y);
  return y;
}

// Returns x^-1/2 for x in [2^-100, 2^100], to 3e-7 of itself.    Source: as reciprocal
template <class Numbers>
VIEWPEEL_INLINE Numbers inverseRoot(const Numbers& x) {
  Numbers y = numberOf(0x5F3759DFu - (bitsOf(x) >> 1));  // relative error 0.035
  const Numbers half = 0.5f * x;
  for (int step = 0; step < 3; ++step) y = y * (1.5f - half * y * y);
  return y;
}

}  // namespace viewpeel
