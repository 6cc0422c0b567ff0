#include "sums/calibrate_counts.h"

#include <algorithm>
#include <cmath>

#include "sums/add_pairs.h"
#include "sums/calibrate_rows.h"
#include "threads.h"

namespace viewpeel {
namespace {

using Rows = std::vector<double>;

constexpr int kMostPasses = 20;
constexpr double kTolerance = 0.1;  // of the standard error of a row sum
constexpr double kMostTilt = 1;     // greatest |y|
constexpr size_t kLeastOfPart = size_t(1) << 16, kMostParts = 32;

// A Pass holds what one pass over the entries finds for each row.
struct Pass {
  Rows gain, slope;  // by how much the row sum grows, input units squared, and its derivative by y_i
};

class Calibration {
 public:
  Calibration(const std::vector<FormFactors::Entry>& entries, const std::vector<bool>& is_counted, double most,
              const Ids& ids, const std::vector<Measured>& rows, const std::vector<Measured>& counted_rows)
      : entries_(entries),
        is_counted_(is_counted),
        most_(most),
        ids_(ids),
        goal_(rows.size()),
        tolerance_(rows.size()),
        y_(rows.size()) {
    for (uint32_t i = 0; i < rows.size(); ++i) {
      const double error = rows[i].standard_error, of_counts = counted_rows[i].standard_error;
      if (!(error > 0) || !ids.isRequested(i)) continue;
      goal_[i] = (1 - rows[i].value) * ids.areas[i] * std::min(1.0, of_counts * of_counts / (error * error));
      tolerance_[i] = kTolerance * error * ids.areas[i];
    }
  }

  // Finds y by Newton's method, in all rows at once. Each row takes half a step, because both rows of a pair move it.
  void solve() {
    for (int pass = 0; pass < kMostPasses; ++pass) {
      const Pass found = evaluate();
      bool is_done = true;
      for (size_t i = 0; i < y_.size(); ++i) {
        const double rest = goal_[i] - found.gain[i];
        if (std::abs(rest) <= tolerance_[i] || !(found.slope[i] > 0)) continue;
        const double y = std::clamp(y_[i] + rest / (2 * found.slope[i]), -kMostTilt, kMostTilt);
        is_done &= y == y_[i];
        y_[i] = y;
      }
      if (is_done) return;
    }
  }

  Rows factors() const {
    Rows factors(y_.size());
    std::ranges::transform(y_, factors.begin(), [](double y) { return std::exp(y); });
    return factors;
  }

  // Returns the calibrated exchange area of a counted pair.
  double valueOf(const FormFactors::Entry& entry, const Rows& factors) const {
    return std::min(entry.exchange_area.value * factors[entry.i] * factors[entry.j],
                    most_ * ids_.smallerArea(entry.i, entry.j));
  }

 private:
  // The entries are divided into parts, whose number does not depend on the number of threads. Their sums are added in
  // one order, so the result has the same bits for any number of threads.
  Pass evaluate() const {
    const size_t rows = y_.size(), parts = std::clamp<size_t>(entries_.size() / kLeastOfPart, 1, kMostParts);
    const Rows of_row = factors();
    std::vector<Pass> found(parts);
    shareOut(threadsFor(entries_.size()), parts, 1, [&](size_t, size_t part) {
      Pass& sums = found[part];
      sums = {Rows(rows), Rows(rows)};
      for (size_t k = entries_.size() * part / parts, end = entries_.size() * (part + 1) / parts; k < end; ++k) {
        if (!is_counted_[k]) continue;
        const FormFactors::Entry& entry = entries_[k];
        const double before = entry.exchange_area.value, after = valueOf(entry, of_row);
        const bool is_free = after < most_ * ids_.smallerArea(entry.i, entry.j);
        for (const uint32_t id : {entry.i, entry.j}) {
          sums.gain[id] += after - before;
          if (is_free) sums.slope[id] += after;
        }
      }
    });
    for (size_t part = 1; part < parts; ++part)
      for (size_t i = 0; i < rows; ++i) {
        found[0].gain[i] += found[part].gain[i];
        found[0].slope[i] += found[part].slope[i];
      }
    return std::move(found[0]);
  }

  const std::vector<FormFactors::Entry>& entries_;
  const std::vector<bool>& is_counted_;
  double most_;
  const Ids& ids_;
  Rows goal_, tolerance_, y_;
};

// Returns which of the entries are pairs without lines.    In: both sorted
std::vector<bool> findCounted(const std::vector<FormFactors::Entry>& entries, const std::vector<LinePair>& with_lines) {
  std::vector<bool> is_counted(entries.size());
  auto line = with_lines.begin();
  for (size_t k = 0; k < entries.size(); ++k) {
    while (line != with_lines.end() && keyOf(*line) < keyOf(entries[k])) ++line;
    is_counted[k] = entries[k].j < kEnvironment && (line == with_lines.end() || keyOf(*line) != keyOf(entries[k]));
  }
  return is_counted;
}

}  // namespace

FormFactors calibrateCounts(FormFactors all, const std::vector<LinePair>& with_lines, double most,
                            const std::vector<Measured>& counted_rows) {
  Ids ids = all.ids();
  std::vector<Measured> rows = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  const std::vector<bool> is_counted = findCounted(entries, with_lines);
  Calibration calibration(entries, is_counted, most, ids, rows, counted_rows);
  calibration.solve();
  const Rows factors = calibration.factors();
  for (size_t k = 0; k < entries.size(); ++k)
    if (is_counted[k]) entries[k].exchange_area.value = calibration.valueOf(entries[k], factors);
  const std::vector<Measured> sums = sumRows(entries, ids.areas);
  for (size_t i = 0; i < rows.size(); ++i) rows[i].value = sums[i].value;
  return {std::move(ids), std::move(entries), std::move(rows)};
}

}  // namespace viewpeel
