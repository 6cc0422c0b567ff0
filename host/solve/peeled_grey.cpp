#include "solve/peeled_grey.h"

#include <cmath>

#include "solve/heat_answers.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

constexpr uint32_t kMostGreySteps = 10'000;

// A Preconditioned solves S h = b for each column by conjugate gradients with the diagonal as preconditioner, all
// columns in the same sweeps.
class Preconditioned {
 public:
  Preconditioned(PeeledExchange& exchange, const VectorXd& reflectivity)
      : exchange_(exchange), root_(reflectivity.cwiseSqrt()) {
    const VectorXd ones = VectorXd::Ones(root_.size());
    diagonal_ = exchange.closed().areas.cwiseProduct(ones - reflectivity) + reflectivity.cwiseProduct(exchange.given());
    scale_ = diagonal_.unaryExpr([](double value) { return value > 0 ? 1 / value : 0.0; });
  }

  // Returns the irradiations H of (A - X R) H = b, with the right side b, the areas A, and the reflectivities R.
  //   In: h: a first guess of R^(1/2) H, which the solution replaces
  Columns solve(const Columns& b, double residual, Columns& h) {
    const Columns right_side = root_.asDiagonal() * b;
    findRoots(right_side, residual, h);
    const Columns reflected = exchange_.multiply(root_.asDiagonal() * h);
    return exchange_.closed().areas.cwiseInverse().asDiagonal() * (b + reflected);
  }
  uint32_t steps() const { return steps_; }

 private:
  Columns apply(const Columns& h) {
    const Columns products = exchange_.multiply(root_.asDiagonal() * h);
    return exchange_.closed().areas.asDiagonal() * h - root_.asDiagonal() * products;
  }

  void findRoots(const Columns& b, double residual, Columns& h) {
    const Eigen::Index columns = b.cols();
    Columns r = h.isZero(0) ? b : Columns(b - apply(h));
    Columns z = scale_.asDiagonal() * r, p = z;
    Eigen::RowVectorXd size = b.cwiseProduct(scale_.asDiagonal() * b).colwise().sum(),
                       rho = r.cwiseProduct(z).colwise().sum();
    for (uint32_t step = 0; (rho.array() > residual * residual * size.array()).any(); ++step) {
      if (step == kMostGreySteps)
        throw Error(ErrorCode::limit,
                    "conjugate gradients did not reach the equations; emissivities are too small, or rows see too "
                    "little: give them more, or leave such rows out");
      const Columns applied = apply(p);
      const Eigen::RowVectorXd along = p.cwiseProduct(applied).colwise().sum();
      for (Eigen::Index k = 0; k < columns; ++k) {
        if (!(along[k] > 0)) {  // solved exactly
          p.col(k).setZero();
          rho[k] = 0;
          continue;
        }
        const double length = rho[k] / along[k];
        h.col(k) += length * p.col(k);
        r.col(k) -= length * applied.col(k);
        z.col(k) = scale_.cwiseProduct(r.col(k));
        const double next = r.col(k).dot(z.col(k));
        p.col(k) = z.col(k) + next / rho[k] * p.col(k);
        rho[k] = next;
      }
      ++steps_;
    }
  }

  PeeledExchange& exchange_;
  VectorXd root_, diagonal_, scale_;
  uint32_t steps_ = 0;
};

// ReplicateErrors have a column for each of R replicates: how far irradiations move if its exchange replaces that of
// all replicates, divided by the square root of R (R - 1). Squares of columns add up to a variance. A row that few
// lines meet has one more error, which no other row shares.
class ReplicateErrors : public CarriedErrors {
 public:
  ReplicateErrors(PeeledExchange& exchange, const HeatState& state, const Outside& outside, Preconditioned& solver)
      : environment_(exchange.closed().environment), up_share_(outside.up_share) {
    constexpr uint32_t kCount = kProductReplicateCount;
    const Eigen::Index n = environment_.size();
    const VectorXd &b = state.radiosity, ones = VectorXd::Ones(n);
    const VectorXd from_up = outside.up_power * ones - b, from_down = outside.down_power * ones - b;
    Columns factors(n, 2);
    factors << b, ones;
    irradiation_.resize(n, kCount);
    for (uint32_t r = 0; r < kCount; ++r) {
      const PeeledExchange::Part part = exchange.multiplyPart(r, factors);
      irradiation_.col(r) = part.products.col(0) - b.cwiseProduct(part.products.col(1)) +
                            part.up.cwiseProduct(from_up) + part.down.cwiseProduct(from_down);
      to_up_[r] = -part.up.dot(from_up);
      to_down_[r] = -part.down.dot(from_down);
    }
    irradiation_.colwise() -= VectorXd(irradiation_.rowwise().mean());
    to_up_ -= Parts::Constant(to_up_.mean());
    to_down_ -= Parts::Constant(to_down_.mean());
    const double scale = 1 / std::sqrt(kCount * (kCount - 1.0));
    irradiation_ *= scale;
    to_up_ *= scale;
    to_down_ *= scale;
    Columns start = Columns::Zero(n, kCount);
    irradiation_ = solver.solve(irradiation_, kErrorResidual, start);
    of_few_lines_ = exchange.errorOfNextLine(b, state.irradiation, outside.power);
  }

  double standardError(const std::vector<Term>& terms) const override {
    Parts changes = Parts::Zero();
    double of_few_lines = 0;  // squares
    for (const Term& term : terms) {
      changes += term.factor * irradiation_.row(term.row);
      of_few_lines += std::pow(term.factor * of_few_lines_[term.row], 2);
    }
    return std::sqrt(changes.squaredNorm() + of_few_lines);
  }

  double environmentError(const VectorXd& reflectivity, Part part) const override {
    const VectorXd ones = VectorXd::Ones(up_share_.size());
    const VectorXd share = part == Part::up ? up_share_ : part == Part::down ? VectorXd(ones - up_share_) : ones;
    Parts changes = environment_.cwiseProduct(share).cwiseProduct(reflectivity).transpose() * irradiation_;
    if (part != Part::down) changes += to_up_;
    if (part != Part::up) changes += to_down_;
    return changes.norm();
  }

 private:
  using Parts = Eigen::Matrix<double, 1, kProductReplicateCount>;

  const VectorXd &environment_, &up_share_;
  Columns irradiation_;
  VectorXd of_few_lines_;  // of irradiations, by row
  Parts to_up_, to_down_;
};

}  // namespace

HeatSolution solvePeeledGrey(PeeledExchange& exchange, const SplitRows& rows, double residual, Columns& guess) {
  const ClosedExchange& closed = exchange.closed();
  HeatState state(rows.ids, rows.enclosure, closed.is_open);
  const Outside outside =
      makeOutside(closed, rows.enclosure, [&](double temperature) { return emissivePower(temperature) - state.shift; });
  Preconditioned solver(exchange, state.reflectivity);
  if (guess.size() == 0) guess = Columns::Zero(state.source.size(), 1);
  const Columns arriving = exchange.multiply(state.source) + closed.environment.cwiseProduct(outside.power);
  state.take(solver.solve(arriving, residual, guess).col(0));
  const uint32_t steps = solver.steps();
  const ReplicateErrors errors(exchange, state, outside, solver);
  HeatSolution found = answerHeat(state, closed, outside, errors, rows.answers);
  found.steps = steps;
  return found;
}

}  // namespace viewpeel
