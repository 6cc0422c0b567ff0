#include "solve/band_system.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "solve/heat_errors.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kMostSteps = 100, kMostHalvings = 40, kMostInnerSteps = 500;
constexpr double kSolved = 1e-12, kSolvedAtRounding = 1e-9;  // largest residual, as a share of the largest emission
constexpr double kLinearResidual = 1e-8;                     // largest residual of a Newton step's linear solution
constexpr double kLargestFall = 0.25;                        // a step leaves at least this share of a temperature

}  // namespace

BandSystem::BandSystem(const ClosedExchange& closed, const Enclosure& enclosure)
    : closed_(closed), state_(closed, enclosure) {
  const auto n = static_cast<Index>(enclosure.materials.size());
  const BandVectors& emissivities = state_.emissivities;
  for (size_t k = 0; k < emissivities.size(); ++k) {
    size_t earlier = 0;
    while (emissivities[earlier] != emissivities[k]) ++earlier;
    if (earlier == k) {
      solvers_.push_back(std::make_shared<Irradiation>(closed, VectorXd::Ones(n) - emissivities[k]));
      inverses_.push_back(n <= Index(kMostExactRows) ? std::make_shared<RowMajorMatrix>(solvers_[k]->inverse())
                                                     : std::shared_ptr<RowMajorMatrix>());
    } else {
      solvers_.push_back(solvers_[earlier]);
      inverses_.push_back(inverses_[earlier]);
    }
  }
}

uint32_t BandSystem::steps() const {
  std::set<const Irradiation*> solvers;
  for (const auto& of_band : solvers_) solvers.insert(of_band.get());
  uint32_t steps = 0;
  for (const Irradiation* solver : solvers) steps += solver->steps();
  return steps;
}

void BandSystem::findIrradiations() {
  state_.irradiations.clear();
  for (size_t k = 0; k < state_.bands.size(); ++k) {
    VectorXd emitted(state_.temperatures.size());
    for (Index i = 0; i < emitted.size(); ++i)
      emitted[i] = state_.emissivities[k][i] * state_.power(k, state_.temperatures[i]);
    state_.irradiations.push_back(
        solvers_[k]->solve(closed_.pairs * emitted + closed_.environment.cwiseProduct(state_.outside[k].power)));
  }
}

// Returns how far the heat flux of each free row exceeds the given one, W/m2: the residual of docs/solve.md, eq. (12).
VectorXd BandSystem::excess() const {
  VectorXd excess = VectorXd::Zero(state_.temperatures.size());
  for (Index i = 0; i < excess.size(); ++i) {
    if (!state_.isFree(i)) continue;
    excess[i] = -state_.heatFlux(i);
    for (size_t k = 0; k < state_.bands.size(); ++k)
      excess[i] += state_.emissivities[k][i] * (state_.power(k, state_.temperatures[i]) - state_.irradiations[k][i]);
  }
  return excess;
}

// Guesses temperatures for Newton's method: temperatures of a grey enclosure, with emissivities averaged over black
// emission at the reference temperature.
void BandSystem::guessTemperatures() {
  const auto n = state_.temperatures.size();
  const double reference = state_.reference;
  const double whole = kStefanBoltzmann * std::pow(reference, 4);
  VectorXd emissivity = VectorXd::Zero(n), reflectivity(n), source(n), outside = VectorXd::Zero(n);
  for (size_t k = 0; k < state_.bands.size(); ++k) {
    const double share = whole > 0 ? state_.shifts[k] / whole : k + 1 == state_.bands.size() ? 1 : 0;
    emissivity += share * state_.emissivities[k];
    outside += state_.outside[k].power;
  }
  for (Index i = 0; i < n; ++i) {
    reflectivity[i] = state_.isFree(i) ? 1 : 1 - emissivity[i];
    source[i] = state_.isFree(i) ? state_.heatFlux(i)
                                 : emissivity[i] * (kStefanBoltzmann * std::pow(state_.temperatures[i], 4) - whole);
  }
  const VectorXd arriving =
      Irradiation(closed_, reflectivity).solve(closed_.pairs * source + closed_.environment.cwiseProduct(outside));
  for (Index i = 0; i < n; ++i)
    if (state_.isFree(i))
      state_.temperatures[i] = std::pow(
          std::max(whole + arriving[i] + source[i] / emissivity[i], 1e-4 * whole + kStefanBoltzmann) / kStefanBoltzmann,
          0.25);
}

VectorXd BandSystem::solveRoughly(size_t k, const VectorXd& b) const {
  return inverses_[k] ? VectorXd(*inverses_[k] * b) : solvers_[k]->solveRoughly(b);
}

// Returns how much the heat flux of each free row changes, to first order, when temperatures change by `change`: the
// product of docs/solve.md, eq. (13), with `change`.
VectorXd BandSystem::changeOfFlux(const BandVectors& slopes, const VectorXd& change) const {
  VectorXd flux = VectorXd::Zero(change.size());
  for (size_t k = 0; k < state_.bands.size(); ++k) {
    const VectorXd emitted = slopes[k].cwiseProduct(change);
    flux += emitted - state_.emissivities[k].cwiseProduct(solveRoughly(k, closed_.pairs * emitted));
  }
  for (Index i = 0; i < flux.size(); ++i)
    if (!state_.isFree(i)) flux[i] = 0;
  return flux;
}

// Solves for the change of temperatures by BiCGSTAB (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992), since
// the matrix of several bands is not symmetric. The preconditioner is the change of each row's emission.
VectorXd BandSystem::solveNewton(const VectorXd& right_side) const {
  const Index n = right_side.size();
  BandVectors slopes;
  VectorXd own = VectorXd::Zero(n);
  for (size_t k = 0; k < state_.bands.size(); ++k) own += slopes.emplace_back(state_.slope(k));
  const VectorXd scale = own.unaryExpr([](double value) { return value > 0 ? 1 / value : 0.0; });
  const auto apply = [&](const VectorXd& y) { return changeOfFlux(slopes, scale.cwiseProduct(y)); };
  VectorXd y = VectorXd::Zero(n), residual = right_side, direction = residual;
  const VectorXd shadow = residual;
  const double goal = kLinearResidual * right_side.norm();
  double product = shadow.dot(residual);
  for (int step = 0; step < kMostInnerSteps && residual.norm() > goal && product != 0; ++step) {
    const VectorXd applied = apply(direction);
    const double along = shadow.dot(applied);
    if (along == 0) break;
    const double alpha = product / along;
    const VectorXd half = residual - alpha * applied;
    const VectorXd second = apply(half);
    const double squares = second.squaredNorm(), omega = squares > 0 ? second.dot(half) / squares : 0;
    y += alpha * direction + omega * half;
    residual = half - omega * second;
    const double next = shadow.dot(residual);
    if (omega == 0) break;
    direction = residual + next / product * alpha / omega * (direction - omega * applied);
    product = next;
  }
  return scale.cwiseProduct(y);
}

void BandSystem::solve(const std::vector<std::string>& names) {
  if (!state_.hasFreeRows()) return findIrradiations();
  guessTemperatures();
  findIrradiations();
  VectorXd off = excess();
  for (int step = 0; step < kMostSteps; ++step) {
    double scale = 0;
    for (Index i = 0; i < off.size(); ++i) {
      double emitted = state_.isFree(i) ? std::abs(state_.heatFlux(i)) : 0;
      for (size_t k = 0; k < state_.bands.size(); ++k)
        emitted += state_.emissivities[k][i] * bandPower(state_.bands[k], state_.temperatures[i]);
      scale = std::max(scale, emitted);
    }
    const double size = off.lpNorm<Eigen::Infinity>();
    if (size <= kSolved * scale) return;
    const VectorXd before = state_.temperatures, change = solveNewton(-off);
    const double norm = off.norm();
    double share = 1;
    for (int halving = 0; halving < kMostHalvings; ++halving, share /= 2) {
      state_.temperatures = (before + share * change).cwiseMax(kLargestFall * before);
      findIrradiations();
      off = excess();
      if (off.norm() < norm) break;
    }
    if (!(off.norm() < norm)) {  // rounding prevents smaller residuals
      if (size <= kSolvedAtRounding * scale) return;
      break;
    }
  }
  state_.refuseNegativeEmission(names);
  throw Error(ErrorCode::limit,
              "Newton's method did not find the temperatures of rows with given heat fluxes; give some of them "
              "temperatures");
}

BandResponse BandSystem::respond(const BandVectors& disturbances) const {
  BandResponse response{VectorXd::Zero(state_.temperatures.size()), {}};
  VectorXd flux = VectorXd::Zero(state_.temperatures.size());
  for (size_t k = 0; k < state_.bands.size(); ++k) {
    response.irradiation.push_back(solveRoughly(k, disturbances[k]));
    flux += state_.emissivities[k].cwiseProduct(response.irradiation[k]);
  }
  for (Index i = 0; i < flux.size(); ++i)
    if (!state_.isFree(i)) flux[i] = 0;
  if (!(flux.norm() > 0)) return response;
  response.temperature = solveNewton(flux);
  for (size_t k = 0; k < state_.bands.size(); ++k)
    response.irradiation[k] += solveRoughly(k, closed_.pairs * state_.slope(k).cwiseProduct(response.temperature));
  return response;
}

}  // namespace viewpeel
