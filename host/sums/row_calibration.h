// A calibration moves entries by a factor of each of their two rows, until row sums are what they should be.
// calibrate_rows.h and calibrate_counts.h say which entries, and how.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "threads.h"

namespace viewpeel {

// A RowPass holds what one pass over the entries finds for each row.
struct RowPass {
  std::vector<double> gain, slope;  // by how much a row's sum grows, and the derivative of this by the row's y
};

// Adds up a pass over `count` items: add(k, sums) adds item k to its rows. The items are divided into parts, whose
// number does not depend on the number of threads. Their sums are added in one order, so the result has the same bits
// for any number of threads.
template <class Add>
RowPass sumPass(size_t count, size_t rows, const Add& add) {
  constexpr size_t kLeastOfPart = size_t(1) << 16, kMostParts = 32;
  const size_t parts = std::clamp<size_t>(count / kLeastOfPart, 1, kMostParts);
  std::vector<RowPass> found(parts);
  shareOut(threadsFor(count), parts, 1, [&](size_t, size_t part) {
    RowPass& sums = found[part];
    sums = {std::vector<double>(rows), std::vector<double>(rows)};
    for (size_t k = count * part / parts, end = count * (part + 1) / parts; k < end; ++k) add(k, sums);
  });
  for (size_t part = 1; part < parts; ++part)
    for (size_t i = 0; i < rows; ++i) {
      found[0].gain[i] += found[part].gain[i];
      found[0].slope[i] += found[part].slope[i];
    }
  return std::move(found[0]);
}

// Moves the y of each row whose gain misses its goal by half of Newton's step, because both rows of an entry move it.
//   In: goal, tolerance: double[rows], of the gain; most_step, most: greatest change of a y, and greatest |y|
//   Out: whether a y has changed; if none has, another pass finds the same
inline bool stepRows(const RowPass& found, const std::vector<double>& goal, const std::vector<double>& tolerance,
                     double most_step, double most, std::vector<double>& y) {
  bool has_changed = false;
  for (size_t i = 0; i < y.size(); ++i) {
    const double rest = goal[i] - found.gain[i];
    if (std::abs(rest) <= tolerance[i] || !(found.slope[i] > 0)) continue;
    const double next = std::clamp(y[i] + std::clamp(rest / (2 * found.slope[i]), -most_step, most_step), -most, most);
    has_changed |= next != y[i];
    y[i] = next;
  }
  return has_changed;
}

}  // namespace viewpeel
