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
using Flags = int32_t __attribute__((vector_size(4 * kLineLanes)));  // all bits or none
using Doubles = double __attribute__((vector_size(8 * kBlockerLanes)));
using LongFlags = int64_t __attribute__((vector_size(8 * kBlockerLanes)));

VIEWPEEL_INLINE Floats all(float x) { return x - Floats{}; }
VIEWPEEL_INLINE Words all(uint32_t x) { return x - Words{}; }
VIEWPEEL_INLINE Doubles all(double x) { return x - Doubles{}; }

template <class Lanes, class Number>
VIEWPEEL_INLINE Lanes load(const Number* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

// The lanes that are flagged, 0 elsewhere.
VIEWPEEL_INLINE Floats keep(Flags flags, Floats x) { return (Floats)((Flags)x & flags); }

VIEWPEEL_INLINE Doubles least(Doubles a, Doubles b) { return a < b ? a : b; }
VIEWPEEL_INLINE Doubles greatest(Doubles a, Doubles b) { return a > b ? a : b; }

// Whether any lane, or every lane, is flagged.
VIEWPEEL_INLINE bool isAny(Flags flags) {
  const auto wide = (LongFlags)flags;
  int64_t any = 0;
  for (int k = 0; k < kBlockerLanes; ++k) any |= wide[k];
  return any != 0;
}
VIEWPEEL_INLINE bool isAny(LongFlags flags) {
  int64_t any = 0;
  for (int k = 0; k < kBlockerLanes; ++k) any |= flags[k];
  return any != 0;
}
VIEWPEEL_INLINE bool isEvery(LongFlags flags) {
  int64_t every = -1;
  for (int k = 0; k < kBlockerLanes; ++k) every &= flags[k];
  return every != 0;
}

// In the order of lanes, in double precision.
VIEWPEEL_INLINE double sumOf(Floats x) {
  double sum = 0;
  for (int k = 0; k < kLineLanes; ++k) sum += double(x[k]);
  return sum;
}

}  // namespace viewpeel
