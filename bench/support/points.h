// PointSource makes points in the four-dimensional unit cube for rivals that sample. Points are independent, or a
// scrambled Sobol' sequence.
//
// The Sobol' sequence has the direction numbers of S. Joe & F. Y. Kuo, Constructing Sobol sequences with better
// two-dimensional projections, SIAM J. Sci. Comput. 30, 2008. Nested uniform scrambling (A. B. Owen 1995) uses the hash
// of S. Laine & T. Karras, Stratified sampling for stochastic transparency, 2011, on reversed bits.
#pragma once
#include <array>
#include <bit>
#include <cstdint>

namespace viewpeel::bench {

enum class Points { random, sobol };

constexpr uint32_t kDimensions = 4;

constexpr uint64_t kSplitMixStep = 0x9E3779B97F4A7C15ull;

struct SplitMix {  // splitmix64 takes far less time than a ray
  uint64_t state;
  uint64_t next() {
    uint64_t z = state += kSplitMixStep;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ z >> 27) * 0x94D049BB133111EBull;
    return z ^ z >> 31;
  }
};

constexpr uint32_t reverseBits(uint32_t x) {
  x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
  x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
  x = (x >> 4 & 0x0F0F0F0Fu) | (x & 0x0F0F0F0Fu) << 4;
  x = (x >> 8 & 0x00FF00FFu) | (x & 0x00FF00FFu) << 8;
  return x >> 16 | x << 16;
}

using DirectionNumbers = std::array<std::array<uint32_t, 32>, kDimensions>;

// Returns direction numbers with reversed bits: bit k of a number is the k-th binary digit after the point.
constexpr DirectionNumbers makeDirectionNumbers() {
  struct Polynomial {
    uint32_t degree, coefficients;
    std::array<uint32_t, 3> first;
  };
  constexpr std::array<Polynomial, kDimensions - 1> kPolynomials = {
      {{1, 0, {1, 0, 0}}, {2, 1, {1, 3, 0}}, {3, 1, {1, 3, 1}}}};
  DirectionNumbers numbers{};
  for (uint32_t k = 0; k < 32; ++k) numbers[0][k] = 1u << (31 - k);
  for (uint32_t d = 1; d < kDimensions; ++d) {
    const Polynomial& p = kPolynomials[d - 1];
    for (uint32_t k = 0; k < 32; ++k) {
      uint32_t& v = numbers[d][k];
      if (k < p.degree) {
        v = p.first[k] << (31 - k);
        continue;
      }
      v = numbers[d][k - p.degree] ^ numbers[d][k - p.degree] >> p.degree;
      for (uint32_t m = 1; m < p.degree; ++m)
        if (p.coefficients >> (p.degree - 1 - m) & 1) v ^= numbers[d][k - m];
    }
  }
  for (auto& dimension : numbers)
    for (uint32_t& v : dimension) v = reverseBits(v);
  return numbers;
}

inline constexpr DirectionNumbers kReversedNumbers = makeDirectionNumbers();

// PointSource returns points in order. The first 2^m points of a Sobol' source are stratified. Two sources of one seed
// and stream are equal.
class PointSource {
 public:
  //   In: stream: different streams have independent points; first: index of the first point
  PointSource(Points points, uint64_t seed, uint64_t stream, uint64_t first = 0)
      : points_(points), random_{mix(seed, stream)} {
    if (points == Points::random) {
      random_.state += 2 * first * kSplitMixStep;  // each point takes two words
      return;
    }
    for (uint32_t& s : scrambles_) s = static_cast<uint32_t>(random_.next());
    index_ = static_cast<uint32_t>(first);
    const uint32_t gray = index_ ^ index_ >> 1;
    for (uint32_t d = 0; d < kDimensions; ++d)
      for (uint32_t k = 0; k < 32; ++k)
        if (gray >> k & 1) reversed_[d] ^= kReversedNumbers[d][k];
  }

  // Returns the next point, with coordinates in units of 2^-32.
  std::array<uint32_t, kDimensions> next() {
    if (points_ == Points::random) {
      const uint64_t a = random_.next(), b = random_.next();
      return {uint32_t(a), uint32_t(a >> 32), uint32_t(b), uint32_t(b >> 32)};
    }
    std::array<uint32_t, kDimensions> point;
    for (uint32_t d = 0; d < kDimensions; ++d) point[d] = reverseBits(scramble(reversed_[d], scrambles_[d]));
    const int flipped = std::countr_one(index_++);
    for (uint32_t d = 0; d < kDimensions; ++d) reversed_[d] ^= kReversedNumbers[d][flipped & 31];
    return point;
  }

 private:
  static uint64_t mix(uint64_t seed, uint64_t stream) {
    return SplitMix{SplitMix{seed}.next() ^ stream * 0xD1342543DE82EF95ull}.next();
  }

  // Scrambles a number with reversed bits. Each bit of the result depends only on lower bits, which are higher bits of
  // the coordinate: intervals of 2^-m stay together, as in Owen's scrambling.
  static uint32_t scramble(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6C50B47Cu;
    x ^= x * 0xB82F1E52u;
    x ^= x * 0xC7AFE638u;
    x ^= x * 0x8D22F6E6u;
    return x;
  }

  Points points_;
  SplitMix random_;
  uint32_t index_ = 0;
  std::array<uint32_t, kDimensions> reversed_{}, scrambles_{};
};

}  // namespace viewpeel::bench
