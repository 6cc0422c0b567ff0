#include "solve/peeled_bands.h"

#include <algorithm>
#include <cmath>

#include "solve/band_answers.h"
#include "solve/peeled_grey.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::Index;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr int kMostNewtonSteps = 50, kMostStepHalvings = 20, kMostTurns = 200;
constexpr uint32_t kMostBandSteps = 10'000;
constexpr double kInnerResidual = 1e-3;  // of a Newton step's linear equations; its later steps gain the other digits
constexpr double kSumRounding = 1e-13;   // of emission in a band, and of the sums of products

// A Linearised holds the equations of all bands for small changes: docs/solve.md, eq. (15). A row of given heat flux
// emits in all bands as its temperature demands, so that each band's irradiation changes the radiosities of all.
// Matrices have n rows and, for each of several systems of equations, a column for each band.
class Linearised {
 public:
  Linearised(PeeledExchange& exchange, const BandState& state) : exchange_(exchange), bands_(Index(state.bandCount())) {
    const Index n = state.temperatures.size();
    emissivity_.resize(n, bands_);
    emission_ = Columns::Zero(n, bands_);
    temperature_ = VectorXd::Zero(n);
    for (Index k = 0; k < bands_; ++k) {
      emissivity_.col(k) = state.emissivities[size_t(k)];
      emission_.col(k) = state.slope(size_t(k));
    }
    for (Index i = 0; i < n; ++i) {
      if (!state.isFree(i)) continue;
      const double slope = emission_.row(i).sum();
      if (slope > 0) {
        emission_.row(i) /= slope;
        temperature_[i] = 1 / slope;
      } else {
        emission_(i, bands_ - 1) = 1;  // near 0 K all radiation has long waves
      }
    }
    const VectorXd &areas = exchange.closed().areas, &given = exchange.given();
    scale_.resize(n, bands_);
    for (Index i = 0; i < n; ++i)
      for (Index k = 0; k < bands_; ++k) {
        const double reflected = 1 - emissivity_(i, k) + emission_(i, k) * emissivity_(i, k);
        const double diagonal = areas[i] * (1 - reflected) + reflected * given[i];
        scale_(i, k) = diagonal > 0 ? 1 / diagonal : 0;
      }
  }

  // Returns how radiosities change with irradiations.
  Columns radiate(const Columns& h) const {
    Columns b(h.rows(), h.cols());
    for (Index from = 0; from < h.cols(); from += bands_) {
      const auto arriving = h.middleCols(from, bands_);
      const VectorXd absorbed = emissivity_.cwiseProduct(arriving).rowwise().sum();
      b.middleCols(from, bands_) = arriving - emissivity_.cwiseProduct(arriving) + absorbed.asDiagonal() * emission_;
    }
    return b;
  }
  // Returns how temperatures change with the irradiations of one system.
  VectorXd warm(const Columns& h) const {
    return temperature_.cwiseProduct(VectorXd(emissivity_.cwiseProduct(h).rowwise().sum()));
  }
  // Returns the size of each system's residuals, in which small polygons have small parts.
  RowVectorXd sizes(const Columns& r) const { return dots(r, precondition(r)).cwiseSqrt(); }

  // Returns the changes h of irradiations for which A h - X (change of radiosities) = b, for each system.
  //   BiCGSTAB (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992, 631-644), all systems in the same sweeps.
  //   In: residuals: by system, relative
  Columns solve(const Columns& b, double residual, uint32_t& steps) const {
    Columns h = Columns::Zero(b.rows(), b.cols()), r = b, p = b;
    const Columns shadow = precondition(b);
    const RowVectorXd goals = residual * sizes(b);
    RowVectorXd rho = dots(shadow, r);
    for (uint32_t step = 0; (sizes(r).array() > goals.array()).any(); ++step) {
      if (step == kMostBandSteps || !rho.allFinite())
        throw Error(ErrorCode::limit,
                    "the equations of all bands were not solved; emissivities are too small, or rows see too little: "
                    "give them more, or leave such rows out");
      Columns toward = precondition(p);
      const Columns applied = apply(toward);
      const RowVectorXd alpha = ratios(rho, dots(shadow, applied));
      add(h, alpha, toward);
      add(r, -alpha, applied);
      toward = precondition(r);
      const Columns second = apply(toward);
      const RowVectorXd omega = ratios(dots(second, r), dots(second, second));
      add(h, omega, toward);
      add(r, -omega, second);
      const RowVectorXd next = dots(shadow, r);
      const RowVectorXd beta = ratios(next, rho).cwiseProduct(ratios(alpha, omega));
      add(p, -omega, applied);
      p = scaled(p, beta) + r;
      rho = next;
      ++steps;
    }
    return h;
  }

 private:
  Columns precondition(const Columns& r) const {
    Columns z(r.rows(), r.cols());
    for (Index from = 0; from < r.cols(); from += bands_)
      z.middleCols(from, bands_) = scale_.cwiseProduct(r.middleCols(from, bands_));
    return z;
  }
  Columns apply(const Columns& h) const {
    return exchange_.closed().areas.asDiagonal() * h - exchange_.multiply(radiate(h));
  }
  RowVectorXd dots(const Columns& a, const Columns& b) const {
    RowVectorXd sums(a.cols() / bands_);
    for (Index s = 0; s < sums.size(); ++s)
      sums[s] = a.middleCols(s * bands_, bands_).cwiseProduct(b.middleCols(s * bands_, bands_)).sum();
    return sums;
  }
  // Returns quotients, 0 where the divisor is 0: that system is solved exactly.
  static RowVectorXd ratios(const RowVectorXd& a, const RowVectorXd& b) {
    return a.binaryExpr(b, [](double x, double y) { return y == 0 ? 0 : x / y; });
  }
  Columns scaled(const Columns& a, const RowVectorXd& factors) const {
    Columns product(a.rows(), a.cols());
    for (Index k = 0; k < a.cols(); ++k) product.col(k) = factors[k / bands_] * a.col(k);
    return product;
  }
  void add(Columns& to, const RowVectorXd& factors, const Columns& a) const { to += scaled(a, factors); }

  PeeledExchange& exchange_;
  Index bands_;
  Columns emissivity_, emission_;  // emission_: how radiosities of free rows change per unit of absorbed radiation
  VectorXd temperature_;           // K per unit of absorbed radiation, W/m2; 0 for rows of given temperature
  Columns scale_;                  // preconditioner
};

// Finds the temperature at which a free row emits what it absorbs and its heat flux, by Newton's method between bounds.
double temperatureOf(const BandState& state, Index row, const Columns& h) {
  double power = state.heatFlux(row);
  for (size_t k = 0; k < state.bandCount(); ++k) power += state.emissivities[k][row] * h(row, Index(k));
  const auto excess = [&](double temperature) {
    double sum = -power;
    for (size_t k = 0; k < state.bandCount(); ++k) sum += state.emissivities[k][row] * state.power(k, temperature);
    return sum;
  };
  double low = 0, high = std::max(state.temperatures[row], 1.0);
  if (!(excess(low) < 0)) return 0;
  while (excess(high) < 0) low = high, high *= 2;
  double at = std::clamp(state.temperatures[row], low, high);
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const double off = excess(at);
    (off < 0 ? low : high) = at;
    double slope = 0;
    for (size_t k = 0; k < state.bandCount(); ++k) slope += state.emissivities[k][row] * state.powerSlope(k, at);
    double next = slope > 0 ? at - off / slope : low;
    if (!(next > low && next < high)) next = low + (high - low) / 2;
    if (std::abs(next - at) <= 1e-15 * at || next <= low || next >= high) return next;
    at = next;
  }
  return at;
}

class PeeledBands {
 public:
  PeeledBands(PeeledExchange& exchange, const SplitRows& rows)
      : exchange_(exchange), ids_(rows.ids), closed_(exchange.closed()), state_(closed_, rows.enclosure) {}

  // Finds irradiations by Newton's method. Temperatures follow from irradiations row by row, so that nothing but the
  // sums of exchange is left to solve.
  void solve(double residual, Columns& guess) {
    const auto bands = Index(state_.bandCount());
    outside_.resize(closed_.areas.size(), bands);
    for (Index k = 0; k < bands; ++k)
      outside_.col(k) = closed_.environment.cwiseProduct(state_.outside[size_t(k)].power);
    Columns h = Columns::Zero(closed_.areas.size(), bands);
    Columns off = lackOf(h);
    const Linearised at_first(exchange_, state_);  // whose weights measure all residuals
    const double goal = residual * at_first.sizes(off)[0] + kSumRounding * at_first.sizes(emissions())[0];
    if (guess.size() > 0) off = lackOf(h = guess);
    double size = at_first.sizes(off)[0];
    for (int step = 0; size > goal; ++step) {
      if (step == kMostNewtonSteps) fail();
      const double rest = goal / (2 * size), inner = state_.hasFreeRows() ? std::max(kInnerResidual, rest) : rest;
      const Columns before = h;
      const Columns change = Linearised(exchange_, state_).solve(off, inner, steps_);
      double share = 1, now = INFINITY;
      for (int halving = 0; halving < kMostStepHalvings && !(now < size); ++halving, share /= 2) {
        h = before + share * change;
        off = lackOf(h);
        now = at_first.sizes(off)[0];
      }
      if (!(now < size)) fail();
      size = now;
    }
    state_.refuseNegativeEmission(ids_.names);
    guess = h;
  }

  HeatSolution answer() {
    const BandErrors errors = carryReplicateErrors();
    HeatSolution found = answerBands(ids_, state_, closed_, errors);
    found.steps = steps_;
    return found;
  }

 private:
  [[noreturn]] void fail() const {
    state_.refuseNegativeEmission(ids_.names);
    throw Error(ErrorCode::limit,
                "Newton's method did not find the temperatures of rows with given heat fluxes; give some of them "
                "temperatures");
  }

  // Takes irradiations, finds the temperatures that follow, and returns by how much A H falls short of what arrives.
  Columns lackOf(const Columns& h) {
    state_.irradiations.clear();
    for (Index k = 0; k < h.cols(); ++k) state_.irradiations.push_back(h.col(k));
    for (Index i = 0; i < h.rows(); ++i)
      if (state_.isFree(i)) state_.temperatures[i] = temperatureOf(state_, i, h);
    Columns radiosities(h.rows(), h.cols());
    for (Index k = 0; k < h.cols(); ++k) radiosities.col(k) = state_.radiosity(size_t(k));
    return exchange_.multiply(radiosities) + outside_ - closed_.areas.asDiagonal() * h;
  }

  // Returns what rows emit in each band, W.
  Columns emissions() const {
    Columns emissions(outside_.rows(), outside_.cols());
    for (Index i = 0; i < emissions.rows(); ++i)
      for (Index k = 0; k < emissions.cols(); ++k) {
        const auto band = size_t(k);
        emissions(i, k) =
            closed_.areas[i] * state_.emissivities[band][i] * bandPower(state_.bands[band], state_.temperatures[i]);
      }
    return emissions;
  }

  // Returns a column for each of R replicates: how far answers move if its exchange replaces that of all replicates,
  // divided by the square root of R (R - 1). Squares of columns add up to a variance.
  BandErrors carryReplicateErrors() const {
    constexpr uint32_t kCount = kProductReplicateCount;
    const auto bands = Index(state_.bandCount());
    const Index n = closed_.areas.size();
    Columns factors(n, bands + 1);
    for (Index k = 0; k < bands; ++k) factors.col(k) = state_.radiosity(size_t(k));
    factors.col(bands).setOnes();
    Columns of_bands(n, kCount * bands);
    Columns up(n, kCount), down(n, kCount);
    for (uint32_t r = 0; r < kCount; ++r) {
      const PeeledExchange::Part part = exchange_.multiplyPart(r, factors);
      up.col(r) = part.up, down.col(r) = part.down;
      for (Index k = 0; k < bands; ++k) {
        const Outside& outside = state_.outside[size_t(k)];
        const VectorXd b = factors.col(k), ones = VectorXd::Ones(n);
        of_bands.col(r * bands + k) = part.products.col(k) - b.cwiseProduct(part.products.col(bands)) +
                                      part.up.cwiseProduct(outside.up_power * ones - b) +
                                      part.down.cwiseProduct(outside.down_power * ones - b);
      }
    }
    const double scale = 1 / std::sqrt(kCount * (kCount - 1.0));
    const auto centre = [&](Columns& columns, Index first, Index stride) {
      VectorXd mean = VectorXd::Zero(n);
      for (Index r = 0; r < Index(kCount); ++r) mean += columns.col(r * stride + first) / kCount;
      for (Index r = 0; r < Index(kCount); ++r)
        columns.col(r * stride + first) = scale * (columns.col(r * stride + first) - mean);
    };
    for (Index k = 0; k < bands; ++k) centre(of_bands, k, bands);
    centre(up, 0, 1), centre(down, 0, 1);
    const Linearised linear(exchange_, state_);
    uint32_t steps = 0;
    const Columns changes = linear.solve(of_bands, kErrorResidual, steps);
    BandErrors errors(closed_, state_, kCount, kCount, 1);
    for (Index r = 0; r < Index(kCount); ++r) {
      BandDisturbance disturbance(n, size_t(bands));
      disturbance.up = up.col(r);
      disturbance.environment = up.col(r) + down.col(r);
      const Columns change = changes.middleCols(r * bands, bands);
      BandResponse response{linear.warm(change), {}};
      for (Index k = 0; k < bands; ++k) response.irradiation.push_back(change.col(k));
      errors.put(size_t(r), disturbance, response);
    }
    Columns of_next_line(n, bands);
    for (Index k = 0; k < bands; ++k)
      of_next_line.col(k) =
          exchange_.errorOfNextLine(factors.col(k), state_.irradiations[size_t(k)], state_.outside[size_t(k)].power);
    BandResponse of_rows{linear.warm(of_next_line), {}};
    for (Index k = 0; k < bands; ++k) of_rows.irradiation.push_back(of_next_line.col(k));
    errors.putOfRows(of_rows);
    return errors;
  }

  PeeledExchange& exchange_;
  const Ids& ids_;
  const ClosedExchange& closed_;
  BandState state_;
  Columns outside_;  // what reaches rows from the environment, W
  uint32_t steps_ = 0;
};

}  // namespace

HeatSolution solvePeeledBands(PeeledExchange& exchange, const SplitRows& rows, double residual, Columns& guess) {
  PeeledBands bands(exchange, rows);
  bands.solve(residual, guess);
  return bands.answer();
}

}  // namespace viewpeel
