// SharedProducts multiply the exchange of rows by vectors where each polygon's lines are shared between two rows, in
// another proportion along each direction: docs/method.md, section 15.
//   y_p += a_p(u) count_ij(u) sum_q a_q(u) x_q   for the rows p of polygon i, the rows q of polygon j, and back
// Here count_ij(u) are the facing lines of i and j along u, and a_p(u) is row p's share of its polygon's lines. The
// factors of rows are x, and their products y.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "engines/pair_products.h"
#include <viewpeel/scene.h>

namespace viewpeel {

// PolygonShares say to which rows the lines of each polygon belong.
struct PolygonShares {
  static constexpr uint32_t kNone = 0xFFFFFFFFu;
  struct Rows {
    uint32_t first, second;  // second is kNone where the first row has all lines
  };
  std::vector<Rows> rows;  // of each polygon of the scene
  uint32_t row_count = 0;
  bool two_sided = false;
  // Returns the share of the first row in the lines along u, in [0, 1]. It is called from any thread, for polygons
  // with two rows.
  std::function<double(uint32_t polygon, const glm::dvec3& u)> share_of_first;
};

// SharedProducts serve one thread. Along one direction they multiply polygons, whose factors are means of their rows'
// factors. Then they share the polygons' sums among rows. Both are rounded to whole numbers in each direction, so that
// sums of several threads do not depend on who counted what.
class SharedProducts {
 public:
  // Begins new products, with sums of 0.
  //   In: shares: kept by reference; factors: int64_t[rows][columns], sizes below 2^52, kept by reference
  void start(const PolygonShares& shares, std::span<const int64_t> factors, size_t columns, bool counts_outside);
  // Begins a direction, whose lines are then added to the products of polygons that are returned.
  PairProducts& begin(const glm::dvec3& u);
  // Ends the direction, and divides the sums of each polygon among its rows.
  void end();

  // Returns a sum, and what a row's lines met outside of all pairs, in 2^-kOutsideBits counts.
  WideInteger sum(size_t row, size_t column) const { return sums_[row * columns_ + column]; }
  struct Outside {
    WideInteger ahead = 0, behind = 0, leak = 0;
  };
  static constexpr int kOutsideBits = 32;
  const Outside& outside(size_t row) const { return outside_[row]; }
  uint64_t sizeBytes() const;

 private:
  const PolygonShares* shares_ = nullptr;
  std::span<const int64_t> factors_;
  size_t columns_ = 1;
  bool counts_outside_ = false;
  PairProducts of_polygons_;
  std::vector<double> share_;             // of the first row of each polygon, along the present direction
  std::vector<int64_t> polygon_factors_;  // [polygons][columns]
  std::vector<WideInteger> sums_;         // [rows][columns]
  std::vector<Outside> outside_;
};

}  // namespace viewpeel
