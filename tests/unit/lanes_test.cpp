// These tests compare lanes with scalars, with vectors of every width.
#include "lanes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "vectorised.h"

namespace viewpeel {
namespace {

// Compares lanes with scalars.
template <class Types>
VIEWPEEL_INLINE void compareLanes(float x) {
  using Floats = typename Types::Floats;
  EXPECT_EQ(reciprocal(Floats(x))[5], reciprocal(x));
  EXPECT_EQ(inverseRoot(Floats(x))[11], inverseRoot(x));
  Floats numbers;
  for (int k = 0; k < kLineLanes; ++k) numbers.set(k, float(1 << k));
  EXPECT_EQ(sumOf(numbers), 65535.0f);  // powers of two add up without rounding
  const float from[kLineLanes + 1] = {9, 0, -1, 2, -3, 4, -5, 6, -7, 8, -9, 10, -11, 12, -13, 14, -15};
  const Floats loaded = load<Floats>(from + 1), sizes = sizeOf(loaded), kept = keep(loaded, Floats(x)),
               chosen = ifAtMost(loaded, Floats(4), Floats(1), Floats(2));
  for (int k = 0; k < kLineLanes; ++k) {
    EXPECT_EQ(loaded[k], from[k + 1]);
    EXPECT_EQ(sizes[k], float(k));
    EXPECT_EQ(kept[k], loaded[k] > 0 ? x : 0);
    EXPECT_EQ(chosen[k], loaded[k] <= 4 ? 1 : 2);
    EXPECT_EQ(least(loaded, Floats(1))[k], std::min(loaded[k], 1.0f));
    EXPECT_EQ(greatest(loaded, Floats(1))[k], std::max(loaded[k], 1.0f));
    EXPECT_EQ(wholeOf(sizes + 0.75f)[k], float(k));
    EXPECT_EQ(floatsOf(typename Types::Words(7u) << 2)[k], 28.0f);
  }
  EXPECT_EQ(bitsAtMost(loaded, Floats(-11)), 0b1010'1000'0000'0000u);
  for (int k = 0; k < kLineLanes; ++k) {
    Floats others = 2;
    others.set(k, 1);
    const Floats ones = 1;
    EXPECT_EQ(bitsAtMost(others, ones), 1u << k);
    EXPECT_TRUE(isAnyAtMost(others, ones) && isAnyBelow(ones, others) && areAllAtMost(ones, others));
    EXPECT_FALSE(isAnyAtMost(Floats(2), ones) || isAnyBelow(others, ones) || areAllAtMost(others, ones));
  }
  using Doubles = typename Types::Doubles;
  for (int k = 0; k < kBlockerLanes; ++k) {
    Doubles others = 1 + 0x1p-52;
    others.set(k, 1);
    EXPECT_EQ(bitsAtMost<Doubles>(others, 1), 1u << k);
    EXPECT_FALSE(areAllAtMost<Doubles>(others, 1));
    EXPECT_TRUE(areAllAtMost<Doubles>(1, others));
  }
}

// The first guesses are off by 0.13 (reciprocal) and 0.035 (root). Three of Newton's steps leave 3e-7, rounding
// included.
TEST(Lanes, ReciprocalsAndRootsAreTo3e7) {
  std::mt19937_64 bits(3);
  std::uniform_real_distribution<float> mantissas(1, 2);
  std::uniform_int_distribution exponents(-99, 99);
  for (int trial = 0; trial < 20000; ++trial) {
    const float x = std::ldexp(mantissas(bits), exponents(bits));
    EXPECT_NEAR(double(reciprocal(x)) * double(x), 1, 3e-7) << x;
    EXPECT_NEAR(double(inverseRoot(x)) * std::sqrt(double(x)), 1, 3e-7) << x;
    if (trial % 100) continue;
    for (const Vectors vectors : {Vectors::plain, Vectors::avx2, Vectors::avx512})
      if (vectors <= widestVectors())
        runInLanes(
            vectors, [&]<class Types>(Types) __attribute__((always_inline)) { compareLanes<Types>(x); });
  }
}

}  // namespace
}  // namespace viewpeel
