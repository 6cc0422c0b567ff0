#include "solve/heat_bounds.h"

#include <algorithm>
#include <cmath>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

constexpr int kMostBoundTurns = 200;
constexpr double kRoom = 1.05;  // the next guess is this multiple of what the last one turned out to need

// Returns the largest distance from an entry's exchange area to an end of its interval.
double widthOf(const FormFactors& measured, size_t k) {
  const double value = measured.entries()[k].exchange_area.value;
  const Interval& interval = measured.intervals()[k];
  return std::max({0.0, interval.upper - value, value - interval.lower});
}

// A Spread bounds |(X~ - X) values| in each row. X are the closed exchange areas that were measured, and X~ any that
// lie within their intervals.
class Spread {
 public:
  Spread(const FormFactors& measured, const ClosedExchange& closed)
      : measured_(measured), is_open_(closed.is_open), diagonal_(VectorXd::Zero(closed.areas.size())) {
    // A row's lack is on the diagonal of X; in truth the environment or a partner exchanges it.
    VectorXd lack = closed.areas - closed.environment;
    for (const FormFactors::Entry& entry : measured.entries()) {
      if (entry.j >= kEnvironment) continue;
      lack[entry.i] -= entry.exchange_area.value;
      if (entry.i != entry.j) lack[entry.j] -= entry.exchange_area.value;
    }
    if (is_open_) diagonal_ = lack.cwiseAbs();
  }

  VectorXd of(const VectorXd& values) const {
    VectorXd spread = diagonal_.cwiseProduct(values.cwiseAbs());
    for (size_t k = 0; k < measured_.entries().size(); ++k) {
      const auto [i, j] = std::pair(measured_.entries()[k].i, measured_.entries()[k].j);
      if (j >= kEnvironment) continue;
      const double width = widthOf(measured_, k);
      if (is_open_) {
        // The row's environment, whose value is 0, loses what the pair gains.
        spread[i] += width * std::abs(values[j]);
        if (i != j) spread[j] += width * std::abs(values[i]);
      } else if (i != j) {
        // Rows sum to 1, so the row itself loses what a partner gains.
        const double difference = width * std::abs(values[j] - values[i]);
        spread[i] += difference;
        spread[j] += difference;
      }
    }
    return spread;
  }

 private:
  const FormFactors& measured_;
  bool is_open_;
  VectorXd diagonal_;
};

}  // namespace

VectorXd boundIrradiation(const FormFactors& measured, const ClosedExchange& closed, const Irradiation& irradiation,
                          const VectorXd& radiosity) {
  const Spread spread(measured, closed);
  const VectorXd right_side = spread.of(radiosity), reflectivity = irradiation.roots().cwiseAbs2();
  VectorXd guess = VectorXd::Zero(right_side.size());
  for (int turn = 0; turn < kMostBoundTurns; ++turn) {
    VectorXd bound = irradiation.solve(right_side + guess);
    if (!bound.allFinite() || bound.norm() > 1e100) break;
    // With w = bound, (A - X~ R) w >= v + guess - |X~ - X| R w: docs/solve.md, eq. (10). This is at least v if the
    // guess is at least |X~ - X| R w.
    const VectorXd needed = spread.of(reflectivity.cwiseProduct(bound));
    if ((needed.array() <= guess.array()).all()) return bound;
    guess = kRoom * needed;
  }
  return VectorXd::Constant(right_side.size(), INFINITY);
}

}  // namespace viewpeel
