#include "engines/shared_products.h"

#include <algorithm>
#include <cmath>

namespace viewpeel {
namespace {

// Returns a share of a whole number, as a whole number.
WideInteger shareOf(double share, WideInteger whole) {
  return static_cast<WideInteger>(std::rint(share * static_cast<double>(whole)));
}

}  // namespace

void SharedProducts::start(const PolygonShares& shares, std::span<const int64_t> factors, size_t columns,
                           bool counts_outside) {
  shares_ = &shares;
  factors_ = factors;
  columns_ = columns;
  counts_outside_ = counts_outside;
  share_.assign(shares.rows.size(), 1);
  polygon_factors_.resize(shares.rows.size() * columns);
  sums_.assign(shares.row_count * columns, 0);
  outside_.assign(counts_outside ? shares.row_count : 0, {});
}

PairProducts& SharedProducts::begin(const glm::dvec3& u) {
  for (uint32_t k = 0; k < shares_->rows.size(); ++k) {
    const auto [first, second] = shares_->rows[k];
    const int64_t* of_first = &factors_[first * columns_];
    int64_t* factors = &polygon_factors_[k * columns_];
    if (second == PolygonShares::kNone) {
      std::copy_n(of_first, columns_, factors);
      continue;
    }
    const int64_t* of_second = &factors_[second * columns_];
    share_[k] = shares_->share_of_first(k, u);
    // Equal factors stay as they are.
    for (size_t c = 0; c < columns_; ++c)
      factors[c] = of_second[c] + std::llrint(share_[k] * static_cast<double>(of_first[c] - of_second[c]));
  }
  of_polygons_.start(polygon_factors_, columns_, counts_outside_);
  return of_polygons_;
}

void SharedProducts::end() {
  of_polygons_.settle();
  for (size_t k = 0; k < shares_->rows.size(); ++k) {
    const auto [first, second] = shares_->rows[k];
    const bool is_shared = second != PolygonShares::kNone;
    // The second row has what the first row leaves, so that nothing is lost.
    const auto add = [&](WideInteger whole, WideInteger& to_first, WideInteger* to_second) {
      const WideInteger part = is_shared ? shareOf(share_[k], whole) : whole;
      to_first += part;
      if (to_second) *to_second += whole - part;
    };
    for (size_t c = 0; c < columns_; ++c)
      add(of_polygons_.sum(k, c), sums_[first * columns_ + c], is_shared ? &sums_[second * columns_ + c] : nullptr);
    if (!counts_outside_) continue;
    const PairProducts::Outside& outside = of_polygons_.outside(k);
    Outside &of_first = outside_[first], *of_second = is_shared ? &outside_[second] : nullptr;
    const auto addOutside = [&](uint64_t counts, WideInteger Outside::*part) {
      if (counts) add(WideInteger(counts) << kOutsideBits, of_first.*part, of_second ? &(of_second->*part) : nullptr);
    };
    addOutside(outside.ahead, &Outside::ahead);
    addOutside(outside.behind, &Outside::behind);
    addOutside(outside.leak, &Outside::leak);
  }
}

uint64_t SharedProducts::sizeBytes() const {
  return of_polygons_.sizeBytes() + share_.capacity() * sizeof(double) + polygon_factors_.capacity() * sizeof(int64_t) +
         sums_.capacity() * sizeof(WideInteger) + outside_.capacity() * sizeof(Outside);
}

}  // namespace viewpeel
