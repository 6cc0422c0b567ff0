// PairProducts multiply the exchange of pairs by vectors while a Sweep peels a scene. Nothing is stored but vectors.
//   y_i += count_ij x_j,  y_j += count_ij x_i   for every facing pair that the sweep finds
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/ids.h>

namespace viewpeel {

__extension__ using WideInteger = __int128;

// PairProducts serve one thread. Factors are whole numbers and sums are exact. So sums of several threads do not depend
// on which thread counted what, and the matrix is symmetric to the last bit.
class PairProducts {
 public:
  // Lines that leave the scene against the direction are counted here, where the environment is split.
  static constexpr uint32_t kBehind = kEnvironment - 1;

  // The Outside of a row counts lines that join it to no other row, so that they add nothing to a product. These lines
  // leave the scene along the direction (ahead) or against it (behind), end on a back, or stay within the row (within).
  struct Outside {
    uint64_t ahead = 0, behind = 0, leak = 0, within = 0;
  };

  // Begins new products, with sums of 0.
  //   In: factors: int64_t[rows][columns], sizes below 2^53; counts_outside: whether lines without a pair are counted
  void start(std::span<const int64_t> factors, size_t columns, bool counts_outside);
  // Adds a weight of facing lines.    In: i: a row; j: a row, kEnvironment, kBehind or kLeak; weight: below 2^44
  void add(uint32_t i, uint32_t j, uint64_t weight) {
    if (j >= kBehind || i == j) {
      addOutside(i, j, weight);
      return;
    }
    __builtin_prefetch(&cells_[i * columns_], 1);
    __builtin_prefetch(&cells_[j * columns_], 1);
    Coming& earlier = coming_[turn_++ % kComing];
    multiply(earlier);
    earlier = {i, j, static_cast<int64_t>(weight)};
  }
  // Satisfies Sweep; blocked pairs have no part in products.
  void addBlocked(uint32_t, uint32_t, uint64_t) {}
  // Adds the pairs whose cells are still on their way from memory.
  void settle();

  // These two return a row's product in one column, and the lines of a row that belong to no pair. Both need settle()
  // before them.
  WideInteger sum(size_t row, size_t column) const { return cells_[row * columns_ + column].sum; }
  const Outside& outside(size_t row) const { return outside_[row]; }
  uint64_t sizeBytes() const { return cells_.capacity() * sizeof(Cell) + outside_.capacity() * sizeof(Outside); }

 private:
  static constexpr uint32_t kComing = 16;  // pairs whose cells are on their way from memory at once

  // A row's factor and sum stand together, so that a pair takes two places of memory.
  struct Cell {
    WideInteger sum = 0;
    int64_t factor = 0;
  };
  struct Coming {
    uint32_t i = 0, j = 0;
    int64_t weight = 0;
  };

  void multiply(const Coming& pair) {
    Cell *of_i = &cells_[pair.i * columns_], *of_j = &cells_[pair.j * columns_];
    for (size_t k = 0; k < columns_; ++k) {
      of_i[k].sum += WideInteger(pair.weight) * of_j[k].factor;
      of_j[k].sum += WideInteger(pair.weight) * of_i[k].factor;
    }
  }
  void addOutside(uint32_t i, uint32_t j, uint64_t weight) {
    if (!counts_outside_) return;
    Outside& of_row = outside_[i];
    (j == kEnvironment ? of_row.ahead
     : j == kBehind    ? of_row.behind
     : j == kLeak      ? of_row.leak
                       : of_row.within) += weight;
  }

  size_t columns_ = 1;
  bool counts_outside_ = false;
  std::vector<Cell> cells_;  // [rows][columns]
  std::vector<Outside> outside_;
  std::array<Coming, kComing> coming_{};
  uint32_t turn_ = 0;
};

}  // namespace viewpeel
