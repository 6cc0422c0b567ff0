#include "reference/exact/outline_grid.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace viewpeel::reference {

OutlineGrid::OutlineGrid(const Projection& projection)
    : projection_(projection), seen_(projection.outlines().size(), 0) {
  const std::vector<Outline>& outlines = projection.outlines();
  if (outlines.empty()) {
    first_.assign(2, 0);
    return;
  }
  glm::dvec2 high = outlines[0].high;
  low_ = outlines[0].low;
  for (const Outline& outline : outlines) {
    low_ = glm::min(low_, outline.low);
    high = glm::max(high, outline.high);
  }
  cells_per_side_ = std::clamp(static_cast<int>(2 * std::sqrt(static_cast<double>(outlines.size()))), 1, 4096);
  cell_ = glm::max((high - low_) / static_cast<double>(cells_per_side_), glm::dvec2(1e-300));

  const auto visit = [&](auto&& action) {
    for (uint32_t k = 0; k < outlines.size(); ++k)
      for (int y = row(outlines[k].low.y); y <= row(outlines[k].high.y); ++y)
        for (int x = column(outlines[k].low.x); x <= column(outlines[k].high.x); ++x)
          action(static_cast<size_t>(y) * cells_per_side_ + x, k);
  };
  const size_t cell_count = static_cast<size_t>(cells_per_side_) * cells_per_side_;
  first_.assign(cell_count + 1, 0);
  visit([&](size_t cell, uint32_t) { ++first_[cell + 1]; });
  for (size_t cell = 0; cell < cell_count; ++cell) first_[cell + 1] += first_[cell];
  listed_.resize(first_.back());
  std::vector<uint32_t> next = first_;
  visit([&](size_t cell, uint32_t k) { listed_[next[cell]++] = k; });
}

int OutlineGrid::column(double x) const {
  return static_cast<int>(std::clamp((x - low_.x) / cell_.x, 0.0, cells_per_side_ - 1.0));
}

int OutlineGrid::row(double y) const {
  return static_cast<int>(std::clamp((y - low_.y) / cell_.y, 0.0, cells_per_side_ - 1.0));
}

void OutlineGrid::findNear(uint32_t a, uint32_t b, std::vector<uint32_t>& outlines) {
  outlines.clear();
  ++query_;
  glm::dvec2 p = projection_.vertices()[a].rounded, q = projection_.vertices()[b].rounded;
  if (p.y > q.y) std::swap(p, q);
  const double left = std::min(p.x, q.x), right = std::max(p.x, q.x);
  const int first_row = row(p.y - 1e-9 * cell_.y), last_row = row(q.y + 1e-9 * cell_.y);
  for (int y = first_row; y <= last_row; ++y) {
    // This is the part of the edge within the row, a millionth of a cell longer for rounding. If in doubt it is the
    // whole edge.
    double from = left, to = right;
    if (q.y - p.y > 1e-6 * cell_.y) {
      const auto at = [&](double height) {
        return p.x + (q.x - p.x) * std::clamp((height - p.y) / (q.y - p.y), 0.0, 1.0);
      };
      const double x_low = at(low_.y + (y - 1e-6) * cell_.y), x_high = at(low_.y + (y + 1 + 1e-6) * cell_.y);
      from = std::min(x_low, x_high);
      to = std::max(x_low, x_high);
    }
    for (int x = column(from - 1e-6 * cell_.x); x <= column(to + 1e-6 * cell_.x); ++x) {
      const size_t cell = static_cast<size_t>(y) * cells_per_side_ + x;
      for (uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) {
        const Outline& outline = projection_.outlines()[listed_[k]];
        if (seen_[listed_[k]] == query_) continue;
        seen_[listed_[k]] = query_;
        if (outline.low.x > right || outline.high.x < left || outline.low.y > q.y || outline.high.y < p.y) continue;
        outlines.push_back(listed_[k]);
      }
    }
  }
}

}  // namespace viewpeel::reference
