// Sobol' points in four dimensions, sixteen at a time, with Owen's scrambling.
//
// Source: S. Joe, F. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM J. Sci. Comput.
// 30, 2008; A. Owen, Randomly permuted (t,m,s)-nets and (t,s)-sequences, 1995.
#pragma once
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "hash.h"
#include "lanes.h"
#include "pair_lines/shared.h"

namespace viewpeel {

// SobolBits has the direction numbers of Sobol' points in Gray's order: for each dimension and each bit of a point's
// number, with the first binary digit lowest. Source: Joe & Kuo, new-joe-kuo-6.21201, dimensions 1 to 4.
class SobolBits {
 public:
  static constexpr int kBits = 32, kDimensions = 4;

  constexpr SobolBits() {
    constexpr uint32_t degree[] = {0, 1, 2, 3}, coefficients[] = {0, 0, 1, 1};
    constexpr uint32_t first[][3] = {{1, 0, 0}, {1, 0, 0}, {1, 3, 0}, {1, 3, 1}};
    for (int d = 0; d < kDimensions; ++d) {
      uint32_t numbers[kBits] = {};
      for (uint32_t k = 0; k < kBits; ++k) {
        const uint32_t s = degree[d];
        if (s == 0) numbers[k] = 1u << (31 - k);
        else if (k < s) numbers[k] = first[d][k] << (31 - k);
        else {
          numbers[k] = numbers[k - s] ^ (numbers[k - s] >> s);
          for (uint32_t m = 1; m < s; ++m)
            if (coefficients[d] >> (s - 1 - m) & 1) numbers[k] ^= numbers[k - m];
        }
      }
      for (int k = 0; k < kBits; ++k)
        for (int bit = 0; bit < kBits; ++bit) of[d][k] |= (numbers[k] >> bit & 1) << (31 - bit);
    }
    // The numbers of a block's 16 points differ in four bits, and each lane takes one combination of them.
    for (int d = 0; d < kDimensions; ++d)
      for (uint32_t lane = 0; lane < kLineLanes; ++lane)
        for (int k = 0; k < 4; ++k)
          if (lane >> k & 1) lanes[d][lane] ^= of[d][k];
  }

  // Returns the direction numbers of all dimensions, kDimensions x kBits.
  constexpr std::span<const uint32_t> numbers() const { return {&of[0][0], size_t{kDimensions} * kBits}; }

  // Returns the binary digits of point number k in dimension d, the first digit lowest.
  constexpr uint32_t digitsOf(uint32_t point, int d) const {
    uint32_t digits = 0;
    for (uint32_t gray = point ^ point >> 1, k = 0; gray >> k; ++k)
      if (gray >> k & 1) digits ^= of[d][k];
    return digits;
  }

  uint32_t of[kDimensions][kBits] = {};
  uint32_t lanes[kDimensions][kLineLanes] = {};
};
inline constexpr SobolBits kSobol;
static_assert(1 << 4 == kLineLanes);

// Returns seeds for scrambled(), one a dimension.    In: numbers: of the series of points; other ones give other seeds
inline std::array<uint32_t, SobolBits::kDimensions> scramblesOf(std::initializer_list<uint64_t> numbers) {
  std::array<uint32_t, SobolBits::kDimensions> scrambles;
  for (uint32_t d = 0; d < scrambles.size(); ++d) {
    Hash hash;
    for (const uint64_t number : numbers) hash.add(number);
    hash.add(uint64_t(d));
    scrambles[d] = static_cast<uint32_t>(hash.value() >> 16);
  }
  return scrambles;
}

// Turns the binary digits of Sobol' points into numbers in [0, 1), with Owen's scrambling by a hash (B. Burley,
// Practical hash-based Owen scrambling, JCGT 9(4), 2020; constants of N. Vegdahl, Building a better LK hash, 2021).
template <class Words>
VIEWPEEL_INLINE typename Words::Floats scrambled(const Words& digits, uint32_t seed) {
  Words x = digits ^ (digits * 0x3d20adeau);
  x += seed;
  x *= seed >> 16 | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  x = (x >> 16) | (x << 16);
  return floatsOf(x >> 8) * pair_lines_data::kDigit;
}

}  // namespace viewpeel
