// A RayBundle holds the random numbers of rays from one side of a polygon, sorted by the rays' directions. Neighbours
// go through nearly the same boxes of a RayTree, so that sixteen of them take little longer than one.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "pair_lines/sobol_points.h"

namespace viewpeel {

class RayBundle {
 public:
  static constexpr int kNumbers = SobolBits::kDimensions;  // of a ray: height, turn, and two for the place of its start
  // A bundle of this many rays is full: neighbours are near enough, and the rays fit into the processor's cache.
  static constexpr uint32_t kFull = 4096;
  // Binary digits of Sobol' points, uint32_t[4][points], where the number of points is a multiple of sixteen.
  using Digits = std::array<std::vector<uint32_t>, kNumbers>;

  // Adds rays of a block: points first .. first + count - 1 of a series.
  //   In: first: a multiple of sixteen; scrambles: of the series; block: says whose rays they are
  template <class Words>
  VIEWPEEL_INLINE void add(const Digits& digits, uint32_t first, uint32_t count,
                           const std::array<uint32_t, kNumbers>& scrambles, uint32_t block);
  // Sorts all rays that were added. Then they can be read, in sixteens.
  void sort();
  void clear();

  uint32_t size() const { return size_; }
  uint32_t blockOf(uint32_t ray) const { return sorted_.blocks[ray]; }
  float numberOf(uint32_t ray, int d) const { return sorted_.numbers[d][ray]; }
  // Returns number d, in [0, 1), of each of the sixteen rays from `first` on. Rays beyond size() are arbitrary.
  template <class Floats>
  VIEWPEEL_INLINE Floats numbersOf(uint32_t first, int d) const {
    return load<Floats>(sorted_.numbers[d].data() + first);
  }

 private:
  struct Drawn {
    std::array<std::vector<float>, kNumbers> numbers;  // by ray; longer than size_, for whole sixteens
    std::vector<uint32_t> blocks;                      // by ray

    void fit(uint32_t rays);
  };

  uint32_t size_ = 0;
  Drawn drawn_, sorted_;
  std::vector<uint32_t> cells_;  // by ray as drawn
  std::vector<uint32_t> ends_;   // by cell: rays in it and in the cells before
};

template <class Words>
VIEWPEEL_INLINE void RayBundle::add(const Digits& digits, uint32_t first, uint32_t count,
                                    const std::array<uint32_t, kNumbers>& scrambles, uint32_t block) {
  drawn_.fit(size_ + count);
  for (uint32_t k = 0; k < count; k += kLineLanes)
    for (int d = 0; d < kNumbers; ++d)
      store(scrambled(load<Words>(digits[d].data() + first + k), scrambles[d]), drawn_.numbers[d].data() + size_ + k);
  std::fill_n(drawn_.blocks.begin() + size_, count, block);
  size_ += count;
}

}  // namespace viewpeel
