// A calibration moves entries by a factor of each of their two rows, until row sums are what they should be.
// calibrate_rows.h and calibrate_counts.h say which entries, and how.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "sums/row_sums.h"

namespace viewpeel {

// A pass over the entries finds these totals for each row: by how much the row's sum grows, and the derivative of this
// by the row's y.
enum : size_t { kGain, kSlope };

// Moves the y of each row whose gain misses its goal by half of Newton's step, because both rows of an entry move it.
//   In: goal, tolerance: double[rows], of the gain; most_step, most: greatest change of a y, and greatest |y|
//   Out: whether a y has changed; if none has, another pass finds the same
inline bool stepRows(const RowTotals& found, const std::vector<double>& goal, const std::vector<double>& tolerance,
                     double most_step, double most, std::vector<double>& y) {
  bool has_changed = false;
  for (size_t i = 0; i < y.size(); ++i) {
    const double rest = goal[i] - found[kGain][i];
    if (std::abs(rest) <= tolerance[i] || !(found[kSlope][i] > 0)) continue;
    const double next =
        std::clamp(y[i] + std::clamp(rest / (2 * found[kSlope][i]), -most_step, most_step), -most, most);
    has_changed |= next != y[i];
    y[i] = next;
  }
  return has_changed;
}

}  // namespace viewpeel
