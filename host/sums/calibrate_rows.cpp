#include "sums/calibrate_rows.h"

#include <algorithm>
#include <cmath>

#include "sums/row_calibration.h"
#include "sums/row_sums.h"

namespace viewpeel {
namespace {

using Entry = FormFactors::Entry;
using Rows = std::vector<double>;

constexpr int kMostPasses = 40;
// A row's gain may miss its goal by this share of the standard error of its guesses.
constexpr double kTolerance = 0.01;
constexpr double kMostTilt = 8;  // greatest |y|, so odds change by a factor of at most e^16
// A row's gain is at most this share of what it would gain if all its guessed visibilities were 1 (or 0). The full gain
// would need infinite odds.
constexpr double kMostOfRoom = 0.98;

// Returns the visibility whose odds are odds_factor times the odds of `visibility`, eq. (40).
double tilt(double visibility, double odds_factor) {
  return visibility * odds_factor / (1 - visibility + visibility * odds_factor);
}

class RowCalibration {
 public:
  RowCalibration(const std::vector<Entry>& entries, const std::vector<Guess>& guesses, const Rows& areas)
      : entries_(entries), guesses_(guesses), goal_(areas.size()), tolerance_(areas.size()), y_(areas.size(), 0) {
    Rows missing = areas, together(areas.size()), measured(areas.size()), room_up(areas.size()),
         room_down(areas.size());
    for (const Entry& entry : entries) {
      addToRows(missing, entry, -entry.exchange_area.value);
      addToRows(measured, entry, entry.exchange_area.standard_error * entry.exchange_area.standard_error);
    }
    for (const Guess& guess : guesses) {
      const Entry& entry = entries[guess.entry];
      const double error = entry.exchange_area.standard_error, part = double(guess.weight) * guess.most;
      addToRows(measured, entry, -error * error);
      addToRows(together, entry, guess.weight * error);
      addToRows(room_up, entry, part * (1 - guess.visibility));
      addToRows(room_down, entry, part * guess.visibility);
    }
    for (size_t i = 0; i < areas.size(); ++i) {
      const double common = together[i] * together[i], variance = common + std::max(0.0, measured[i]);
      if (!(common > 0) || !std::isfinite(variance)) continue;
      goal_[i] = std::clamp(missing[i] * common / variance, -kMostOfRoom * room_down[i], kMostOfRoom * room_up[i]);
      tolerance_[i] = kTolerance * std::sqrt(variance);
    }
  }

  // Finds y by Newton's method, in all rows at once.
  void solve() {
    constexpr double kMostStep = 1;
    for (int pass = 0; pass < kMostPasses; ++pass)
      if (!stepRows(evaluate(), goal_, tolerance_, kMostStep, kMostTilt, y_)) return;
  }

  double gainOf(const Guess& guess) const {
    const Entry& entry = entries_[guess.entry];
    return double(guess.weight) * guess.most *
           (tilt(guess.visibility, std::exp(y_[entry.i] + y_[entry.j])) - guess.visibility);
  }

 private:
  // Finds gains and slopes for the present y.
  RowTotals evaluate() const {
    Rows odds(y_.size());
    for (size_t i = 0; i < y_.size(); ++i) odds[i] = std::exp(y_[i]);
    return sumByRow(guesses_.size(), y_.size(), [&](size_t k, RowTotals& totals) {
      const Guess& guess = guesses_[k];
      const Entry& entry = entries_[guess.entry];
      const double weight = double(guess.weight) * guess.most,
                   visibility = tilt(guess.visibility, odds[entry.i] * odds[entry.j]);
      addToRows(totals[kGain], entry, weight * (visibility - guess.visibility));
      addToRows(totals[kSlope], entry, weight * visibility * (1 - visibility));
    });
  }

  const std::vector<Entry>& entries_;
  const std::vector<Guess>& guesses_;
  Rows goal_, tolerance_, y_;
};

}  // namespace

void calibrateRows(std::vector<Entry>& entries, const std::vector<Guess>& guesses, const std::vector<double>& areas) {
  if (guesses.empty()) return;
  RowCalibration calibration(entries, guesses, areas);
  calibration.solve();
  for (const Guess& guess : guesses) {
    double& value = entries[guess.entry].exchange_area.value;
    value = std::max(0.0, value + calibration.gainOf(guess));
  }
}

}  // namespace viewpeel
