// These functions are the logarithm and the arc tangent of numbers in lanes. The C library's results differ in the last
// bit between processors with and without fused multiply-add; these do not.
//   Error: 1 ulp of a logarithm, 3 ulp of an angle; tests/unit/lane_math_test.cpp.
//   Source: as of shaders/double_math.glsl
#pragma once
#include <cstdint>

#include "lanes.h"

namespace viewpeel {

// Returns ln x for normal numbers x > 0.
template <class Doubles>
VIEWPEEL_INLINE Doubles logOf(const Doubles& x) {
  constexpr uint64_t kOne = 0x3FF0000000000000, kLeastFraction = 0x3FE6A09E00000000;  // bits of 1, and of about 2^-1/2
  constexpr uint64_t kFraction = 0x000FFFFFFFFFFFFF, kTwoTo52 = 0x4330000000000000;   // bits 0 to 51; bits of 2^52
  using Words = typename Doubles::Words;
  const Words bits = bitsOf(x) + Words(kOne - kLeastFraction);
  const Doubles k = numberOf((bits >> 52) | Words(kTwoTo52)) - Doubles(0x1p52 + 1023);
  const Doubles f = numberOf((bits & Words(kFraction)) + Words(kLeastFraction)) - Doubles(1.0);
  const Doubles s = f / (2.0 + f), z = s * s, half_square = 0.5 * f * f;
  const Doubles r = z * (6.666666666666735130e-01 +
                         z * (3.999999999940941908e-01 +
                              z * (2.857142874366239149e-01 +
                                   z * (2.222219843214978396e-01 +
                                        z * (1.818357216161805012e-01 +
                                             z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01))))));
  return k * 6.93147180369123816490e-01 -
         ((half_square - (s * (half_square + r) + k * 1.90821492927058770002e-10)) - f);
}

// Returns the angles between (x, y) and the x axis, 0 to pi, for y >= 0 and (x, y) other than (0, 0).
template <class Doubles>
VIEWPEEL_INLINE Doubles angleOf(const Doubles& x, const Doubles& y) {
  const Doubles size = sizeOf(x), low = least(y, size), high = greatest(y, size);
  const Doubles limit = 0.41421356237309503 * high;  // tan(pi/8): beyond it, t is the tangent from the diagonal
  const Doubles t = ifBelow(limit, low, low - high, low) / ifBelow(limit, low, low + high, high), z = t * t;
  const Doubles r = z * (3.33333333333329318027e-01 +
                         z * (-1.99999999998764832476e-01 +
                              z * (1.42857142725034663711e-01 +
                                   z * (-1.11111104054623557880e-01 +
                                        z * (9.09088713343650656196e-02 +
                                             z * (-7.69187620504482999495e-02 +
                                                  z * (6.66107313738753120669e-02 +
                                                       z * (-5.83357013379057348645e-02 +
                                                            z * (4.97687799461593236017e-02 +
                                                                 z * (-3.65315727442169155270e-02 +
                                                                      z * 1.62858201153657823623e-02))))))))));
  const Doubles from_axis = ifBelow(limit, low, Doubles(0.78539816339744830962), Doubles(0.0)) + (t - t * r);
  const Doubles angle = ifBelow(size, y, 1.57079632679489661923 - from_axis, from_axis);
  return ifBelow(x, Doubles(0.0), 3.14159265358979323846 - angle, angle);
}

}  // namespace viewpeel
