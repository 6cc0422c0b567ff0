#include "sums/calibrate_counts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sums/pair_walk.h"
#include "sums/row_calibration.h"
#include "sums/row_sums.h"

namespace viewpeel {
namespace {

using Rows = std::vector<double>;

constexpr int kMostNewtonPasses = 20;
constexpr double kRowTolerance = 0.1;  // of the standard error of a row sum
constexpr double kMostCountTilt = 1;   // greatest |y|

class CountCalibration {
 public:
  CountCalibration(const std::vector<FormFactors::Entry>& entries, const std::vector<bool>& is_counted, double most,
                   const Ids& ids, const std::vector<Measured>& rows, const std::vector<Measured>& counted_rows,
                   const Rows& of_rays)
      : entries_(entries),
        is_counted_(is_counted),
        most_(most),
        ids_(ids),
        of_rays_(of_rays),
        goal_(rows.size()),
        tolerance_(rows.size()),
        y_(rows.size()) {
    for (uint32_t i = 0; i < rows.size(); ++i) {
      const double error = rows[i].standard_error, of_counts = counted_rows[i].standard_error;
      if (!(error > 0) || !ids.isRequested(i)) continue;
      goal_[i] = (1 - rows[i].value) * ids.areas[i] * std::min(1.0, of_counts * of_counts / (error * error));
      tolerance_[i] = kRowTolerance * error * ids.areas[i];
    }
  }

  // Finds y by Newton's method, in all rows at once.
  void solve() {
    for (int pass = 0; pass < kMostNewtonPasses; ++pass)
      if (!stepRows(evaluate(), goal_, tolerance_, INFINITY, kMostCountTilt, y_)) return;
  }

  // Returns the calibrated exchange area of a counted pair.
  double valueOf(const FormFactors::Entry& entry) const { return valueOf(entry, sharesOf(entry)); }

 private:
  // Returns p_ij and p_ji, by which y_i and y_j act on a pair.
  std::array<double, 2> sharesOf(const FormFactors::Entry& entry) const {
    if (of_rays_.empty()) return {1, 1};
    const double a = of_rays_[entry.i], b = of_rays_[entry.j], of_ray = a * b / (a + b),
                 value = entry.exchange_area.value, error = entry.exchange_area.standard_error,
                 efficiency = std::min(1.0, error * error / (value * of_ray));
    return {efficiency * 2 * b / (a + b), efficiency * 2 * a / (a + b)};
  }
  double valueOf(const FormFactors::Entry& entry, const std::array<double, 2>& shares) const {
    const double tilt = shares[0] * y_[entry.i] + shares[1] * y_[entry.j], root = 1 + tilt / 8, square = root * root,
                 fourth = square * square;
    return std::min(entry.exchange_area.value * fourth * fourth, most_ * ids_.smallerArea(entry.i, entry.j));
  }

  // Finds gains and slopes for the present y.
  RowTotals evaluate() const {
    return sumByRow(entries_.size(), y_.size(), [&](size_t k, RowTotals& totals) {
      if (!is_counted_[k]) return;
      const FormFactors::Entry& entry = entries_[k];
      const std::array<double, 2> shares = sharesOf(entry);
      const double before = entry.exchange_area.value, after = valueOf(entry, shares);
      const bool is_free = after < most_ * ids_.smallerArea(entry.i, entry.j);
      for (const auto& [id, share] : {std::pair(entry.i, shares[0]), std::pair(entry.j, shares[1])}) {
        totals[kGain][id] += after - before;
        if (is_free) totals[kSlope][id] += share * after;
      }
    });
  }

  const std::vector<FormFactors::Entry>& entries_;
  const std::vector<bool>& is_counted_;
  double most_;
  const Ids& ids_;
  const Rows& of_rays_;
  Rows goal_, tolerance_, y_;
};

// Returns which of the entries are pairs without lines.    In: both sorted
std::vector<bool> findCounted(const std::vector<FormFactors::Entry>& entries, const std::vector<LinePair>& with_lines) {
  std::vector<bool> is_counted(entries.size());
  PairWalk walk(with_lines);
  for (size_t k = 0; k < entries.size(); ++k) is_counted[k] = entries[k].j < kEnvironment && !walk.find(entries[k]);
  return is_counted;
}

}  // namespace

FormFactors calibrateCounts(FormFactors all, const std::vector<LinePair>& with_lines, double most,
                            const std::vector<Measured>& counted_rows, const std::vector<double>& of_rays) {
  Ids ids = all.ids();
  std::vector<Measured> rows = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  const std::vector<bool> is_counted = findCounted(entries, with_lines);
  CountCalibration calibration(entries, is_counted, most, ids, rows, counted_rows, of_rays);
  calibration.solve();
  for (size_t k = 0; k < entries.size(); ++k)
    if (is_counted[k]) entries[k].exchange_area.value = calibration.valueOf(entries[k]);
  const std::vector<Measured> sums = sumRows(entries, ids.areas);
  for (size_t i = 0; i < rows.size(); ++i) rows[i].value = sums[i].value;
  return {std::move(ids), std::move(entries), std::move(rows)};
}

}  // namespace viewpeel
