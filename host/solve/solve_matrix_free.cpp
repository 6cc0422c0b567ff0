// This file solves the grey enclosure without a matrix: docs/solve.md, eq. (1) to (6) and (14).
//
// All replicates' directions together make one symmetric operator, for which the enclosure is solved once. How far each
// replicate's exchange differs from the exchange of all gives the errors of the answers, to first order.
// Replicates are not solved each alone, for two reasons. The bias of a solution, which is of second order, would be 8
// times as large. A small polygon that no line of a replicate meets would leave its equations without a solution.
#include <viewpeel/matrix_free.h>

#include <cmath>

#include <fmt/format.h>

#include "solve/check_enclosure.h"
#include "solve/heat_answers.h"
#include "solve/peeled_exchange.h"
#include "solve/split_rows.h"
#include "stopwatch.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

constexpr double kBytesOfPair = 80;      // counters, form factors with their errors, and the equations; an estimate
constexpr double kErrorResidual = 1e-3;  // relative residual of the equations for standard errors
constexpr uint32_t kMostSteps = 10'000, kMostDirections = 1 << 16, kScarceRounds = 2;
// Errors of answers are taken to fall as N^-0.6 with N directions. The next N aims at this share of the tolerance.
constexpr double kExponent = 0.6, kMargin = 0.9, kLeastGrowth = 1.5, kMostGrowth = 16;

constexpr HeatTolerance kOfHeat{0.01, HeatTolerance::Of::relative}, kOfTemperatures{1, HeatTolerance::Of::temperature};

struct Stopped {
  bool is_interrupted;
};

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
      if (step == kMostSteps)
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
// all replicates, divided by the square root of R (R - 1). Squares of columns add up to a variance.
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
  }

  double standardError(const std::vector<Term>& terms) const override {
    Parts changes = Parts::Zero();
    for (const Term& term : terms) changes += term.factor * irradiation_.row(term.row);
    return changes.norm();
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
  Parts to_up_, to_down_;
};

class MatrixFreeSolver {
 public:
  MatrixFreeSolver(const Scene& scene, const MaterialTable& materials, const MatrixFreeRequest& request,
                   const MatrixFreeObserver& observer)
      : request_(request), observer_(observer), ids_(makeIds(scene, request.by, request.two_sided)) {
    std::vector<std::string> surface_names;
    for (const Surface& surface : scene.surfaces) surface_names.push_back(surface.name);
    enclosure_ = assignMaterials(materials, ids_, surface_names);
    if (!enclosure_.band_limits_um.empty())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("{}: bands of wavelengths take form factors in memory; say --matrix-free off, or give "
                              "one emissivity",
                              materials.file));
    found_.tolerance = request.tolerance.value_or(areAllFluxesGiven(enclosure_) ? kOfTemperatures : kOfHeat);
    requireTolerance(found_.tolerance, enclosure_);
    split_ = splitRows(scene, ids_, enclosure_);
    exchange_ = std::make_unique<PeeledExchange>(
        scene, split_.ids, split_.shares, request, materials.up,
        PeeledExchange::Watch{.stop = [this] { stopInTime(); },
                              .show = [this](uint64_t done, uint64_t all) { show(done, all); }});
  }

  MatrixFreeHeat solve() {
    try {
      for (uint64_t directions = request_.first_directions;;) {
        exchange_->draw(static_cast<uint32_t>(directions), found_.rounds++);
        if (const std::optional<uint32_t> row = findRowWithoutReference()) {
          if (found_.rounds > kScarceRounds || directions * 4 > kMostDirections)
            refuseWithoutReference(split_.ids.names[*row]);
          directions *= 4;
          continue;
        }
        takeRound(solveRound());
        if (found_.is_reached || directions >= kMostDirections) return found_;
        directions = nextDirections(directions);
      }
    } catch (const Stopped& stopped) {
      if (!has_round_)
        throw Error(ErrorCode::limit, fmt::format("{} before the first answers; let it run longer",
                                                  stopped.is_interrupted ? "the run was stopped" : "time was up"));
      found_.is_interrupted = stopped.is_interrupted;
      found_.seconds = secondsSince(start_);
      return found_;
    }
  }

 private:
  void stopInTime() const {
    if (observer_.should_stop && observer_.should_stop()) throw Stopped{true};
    if (request_.time_limit_s && secondsSince(start_) >= *request_.time_limit_s) throw Stopped{false};
  }

  void show(uint64_t done, uint64_t all) const {
    if (observer_.on_progress) observer_.on_progress(exchange_->productCount() + 1, done, all, reached_);
  }

  // Finds a row of given heat flux that exchanges, even through other rows, with nothing of a given temperature. A
  // vector is 1 for rows that are known to do so, and products with it find further ones.
  std::optional<uint32_t> findRowWithoutReference() {
    const Eigen::Index n = exchange_->closed().areas.size();
    requireMaterials(exchange_->closed(), enclosure_, ids_);
    Columns refers(n, 1);
    for (Eigen::Index i = 0; i < n; ++i)
      refers(i, 0) =
          split_.enclosure.materials[static_cast<size_t>(i)].temperature || exchange_->closed().environment[i] > 0 ? 1
                                                                                                                   : 0;
    for (double referring = refers.sum(); referring < double(n);) {
      const Columns products = exchange_->multiply(refers);
      for (Eigen::Index i = 0; i < n; ++i)
        if (products(i, 0) > 0) refers(i, 0) = 1;
      const double now = refers.sum();
      if (now == referring) break;
      referring = now;
    }
    for (Eigen::Index i = 0; i < n; ++i)
      if (refers(i, 0) == 0) return static_cast<uint32_t>(i);
    return std::nullopt;
  }

  HeatSolution solveRound() {
    const ClosedExchange& closed = exchange_->closed();
    const Enclosure& enclosure = split_.enclosure;
    if (closed.is_open && enclosure.sky_and_ground) {
      EnvironmentParts& parts = split_.enclosure.environment_parts.emplace();
      for (const double share : exchange_->upShare()) parts.up_share.push_back({share, 0});
    }
    HeatState state(split_.ids, enclosure, closed.is_open);
    const Outside outside =
        makeOutside(closed, enclosure, [&](double temperature) { return emissivePower(temperature) - state.shift; });
    Preconditioned solver(*exchange_, state.reflectivity);
    if (guess_.size() == 0) guess_ = Columns::Zero(state.source.size(), 1);
    const Columns arriving = exchange_->multiply(state.source) + closed.environment.cwiseProduct(outside.power);
    state.take(solver.solve(arriving, request_.residual, guess_).col(0));
    steps_ = solver.steps();
    const ReplicateErrors errors(*exchange_, state, outside, solver);
    return answerHeat(state, closed, outside, errors, split_.answers);
  }

  void takeRound(HeatSolution solution) {
    has_round_ = true;
    found_.heat = std::move(solution);
    found_.heat.steps = steps_;
    found_.replicates = kProductReplicateCount;
    found_.directions = exchange_->directionCount();
    found_.sweeps = exchange_->sweeps();
    found_.resolution = exchange_->resolution();
    // Conjugate gradients for all replicates at once keep six vectors for each.
    found_.memory_bytes = exchange_->memoryBytes() + 6 * kProductReplicateCount * sizeof(double) * split_.ids.count();
    found_.seconds = secondsSince(start_);
    reached_ = largestHeatError(found_.heat, found_.tolerance.of);
    found_.is_reached = reached_ <= found_.tolerance.standard_error;
  }

  uint64_t nextDirections(uint64_t directions) const {
    const double excess = reached_ / (kMargin * found_.tolerance.standard_error);
    const double growth = std::clamp(std::pow(excess, 1 / kExponent), kLeastGrowth, kMostGrowth);
    return std::min<uint64_t>(static_cast<uint64_t>(std::ceil(double(directions) * growth)), kMostDirections);
  }

  const MatrixFreeRequest& request_;
  const MatrixFreeObserver& observer_;
  const Clock::time_point start_ = Clock::now();
  Ids ids_;              // of the answers
  Enclosure enclosure_;  // of ids_
  SplitRows split_;      // of which the equations are
  std::unique_ptr<PeeledExchange> exchange_;
  Columns guess_;
  MatrixFreeHeat found_;
  bool has_round_ = false;
  uint32_t steps_ = 0;
  double reached_ = INFINITY;
};

}  // namespace

double matrixBytes(uint64_t rows) { return kBytesOfPair * double(rows) * (double(rows) + 1) / 2; }

MatrixFreeHeat solveMatrixFree(const Scene& scene, const MaterialTable& materials, const MatrixFreeRequest& request,
                               const MatrixFreeObserver& observer) {
  return MatrixFreeSolver(scene, materials, request, observer).solve();
}

}  // namespace viewpeel
