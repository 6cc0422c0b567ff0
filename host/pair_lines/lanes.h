// Numbers of sixteen lines, or of eight blockers, at once: one operation for all lanes, on whatever vectors the
// processor has. Without contraction every lane rounds as a scalar would, so that results are the same bits everywhere.
#pragma once
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

// A condition is a number for each lane, above 0 or not: compilers take comparisons that end in integers apart, lane by
// lane, where they do not know the processor, and leave choices between numbers whole.
VIEWPEEL_INLINE Floats least(const Floats& a, const Floats& b) { return a < b ? a : b; }
VIEWPEEL_INLINE Floats greatest(const Floats& a, const Floats& b) { return a > b ? a : b; }
VIEWPEEL_INLINE Doubles least(const Doubles& a, const Doubles& b) { return a < b ? a : b; }
VIEWPEEL_INLINE Doubles greatest(const Doubles& a, const Doubles& b) { return a > b ? a : b; }

VIEWPEEL_INLINE double least(double a, double b) { return a < b ? a : b; }
VIEWPEEL_INLINE double greatest(double a, double b) { return a > b ? a : b; }

// Returns x where the condition is above 0, else 0.
VIEWPEEL_INLINE Floats keep(const Floats& condition, const Floats& x) { return condition > 0.0f ? x : Floats{}; }

// Returns the largest or least of all lanes.
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

// In the order of lanes, in double precision.
VIEWPEEL_INLINE double sumOf(Floats x) {
  double sum = 0;
  for (int k = 0; k < kLineLanes; ++k) sum += double(x[k]);
  return sum;
}

}  // namespace viewpeel
