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
constexpr double kInnerResidual = 1e-8;                      // largest residual of a Newton step's linear solution
constexpr double kLargestFall = 0.25;                        // a step leaves at least this share of a temperature

// Returns the temperature whose emission is subtracted from all: the environment's, or the first that is given.
double referenceTemperature(const ClosedExchange& closed, const Enclosure& enclosure) {
  if (closed.is_open)
    return enclosure.sky_and_ground ? enclosure.sky_and_ground->up : *enclosure.environment_temperature;
  for (const Material& material : enclosure.materials)
    if (material.temperature) return *material.temperature;
  return 0;
}

}  // namespace

BandSystem::BandSystem(const ClosedExchange& closed, const Enclosure& enclosure)
    : closed_(closed), enclosure_(enclosure) {
  const auto n = static_cast<Index>(enclosure.materials.size());
  const double reference = referenceTemperature(closed, enclosure);
  for (size_t k = 0; k <= enclosure.band_limits_um.size(); ++k) {
    bands_.push_back({k == 0 ? 0 : enclosure.band_limits_um[k - 1],
                      k == enclosure.band_limits_um.size() ? INFINITY : enclosure.band_limits_um[k]});
    shifts_.push_back(bandPower(bands_[k], reference));
    VectorXd emissivity(n);
    for (Index i = 0; i < n; ++i) emissivity[i] = enclosure.materials[static_cast<size_t>(i)].band_emissivities[k];
    emissivities_.push_back(std::move(emissivity));
    outside_.push_back(makeOutside(closed, enclosure, [&](double temperature) { return power(k, temperature); }));
  }
  for (size_t k = 0; k < bands_.size(); ++k) {
    size_t earlier = 0;
    while (emissivities_[earlier] != emissivities_[k]) ++earlier;
    if (earlier == k) {
      solvers_.push_back(std::make_shared<Irradiation>(closed, VectorXd::Ones(n) - emissivities_[k]));
      inverses_.push_back(n <= Index(kMostExactRows) ? std::make_shared<RowMajorMatrix>(solvers_[k]->inverse())
                                                     : std::shared_ptr<RowMajorMatrix>());
    } else {
      solvers_.push_back(solvers_[earlier]);
      inverses_.push_back(inverses_[earlier]);
    }
  }
  temperatures_ = VectorXd::Constant(n, reference);
  for (const Material& material : enclosure.materials) is_free_.push_back(!material.temperature);
  for (Index i = 0; i < n; ++i)
    if (!isFree(i)) temperatures_[i] = *enclosure.materials[static_cast<size_t>(i)].temperature;
}

uint32_t BandSystem::steps() const {
  std::set<const Irradiation*> solvers;
  for (const auto& of_band : solvers_) solvers.insert(of_band.get());
  uint32_t steps = 0;
  for (const Irradiation* solver : solvers) steps += solver->steps();
  return steps;
}

VectorXd BandSystem::radiosity(size_t k) const {
  VectorXd radiosity = irradiations_[k] - emissivities_[k].cwiseProduct(irradiations_[k]);
  for (Index i = 0; i < radiosity.size(); ++i) radiosity[i] += emissivities_[k][i] * power(k, temperatures_[i]);
  return radiosity;
}

void BandSystem::findIrradiations() {
  irradiations_.clear();
  for (size_t k = 0; k < bands_.size(); ++k) {
    VectorXd emitted(temperatures_.size());
    for (Index i = 0; i < emitted.size(); ++i) emitted[i] = emissivities_[k][i] * power(k, temperatures_[i]);
    irradiations_.push_back(
        solvers_[k]->solve(closed_.pairs * emitted + closed_.environment.cwiseProduct(outside_[k].power)));
  }
}

// Returns how far the heat flux of each free row exceeds the given one, W/m2: the residual of docs/solve.md, eq. (12).
VectorXd BandSystem::excess() const {
  VectorXd excess = VectorXd::Zero(temperatures_.size());
  for (Index i = 0; i < excess.size(); ++i) {
    if (!isFree(i)) continue;
    excess[i] = -*enclosure_.materials[static_cast<size_t>(i)].heat_flux;
    for (size_t k = 0; k < bands_.size(); ++k)
      excess[i] += emissivities_[k][i] * (power(k, temperatures_[i]) - irradiations_[k][i]);
  }
  return excess;
}

// Guesses temperatures for Newton's method: temperatures of a grey enclosure, with emissivities averaged over black
// emission at the reference temperature.
void BandSystem::guessTemperatures() {
  const auto n = temperatures_.size();
  const double reference = referenceTemperature(closed_, enclosure_);
  const double whole = kStefanBoltzmann * std::pow(reference, 4);
  VectorXd emissivity = VectorXd::Zero(n), reflectivity(n), source(n), outside = VectorXd::Zero(n);
  for (size_t k = 0; k < bands_.size(); ++k) {
    const double share = whole > 0 ? shifts_[k] / whole : k + 1 == bands_.size() ? 1 : 0;
    emissivity += share * emissivities_[k];
    outside += outside_[k].power;
  }
  for (Index i = 0; i < n; ++i) {
    reflectivity[i] = isFree(i) ? 1 : 1 - emissivity[i];
    source[i] = isFree(i) ? *enclosure_.materials[static_cast<size_t>(i)].heat_flux
                          : emissivity[i] * (kStefanBoltzmann * std::pow(temperatures_[i], 4) - whole);
  }
  const VectorXd arriving =
      Irradiation(closed_, reflectivity).solve(closed_.pairs * source + closed_.environment.cwiseProduct(outside));
  for (Index i = 0; i < n; ++i)
    if (isFree(i))
      temperatures_[i] = std::pow(
          std::max(whole + arriving[i] + source[i] / emissivity[i], 1e-4 * whole + kStefanBoltzmann) / kStefanBoltzmann,
          0.25);
}

// Returns the derivative of each free row's emission in a band with respect to its temperature, W/m2 per kelvin; 0 for
// other rows.
VectorXd BandSystem::slope(size_t k) const {
  VectorXd slope = VectorXd::Zero(temperatures_.size());
  for (Index i = 0; i < slope.size(); ++i)
    if (isFree(i)) slope[i] = emissivities_[k][i] * powerSlope(k, temperatures_[i]);
  return slope;
}

VectorXd BandSystem::solveRoughly(size_t k, const VectorXd& b) const {
  return inverses_[k] ? VectorXd(*inverses_[k] * b) : solvers_[k]->solveRoughly(b);
}

// Returns how much the heat flux of each free row changes, to first order, when temperatures change by `change`: the
// product of docs/solve.md, eq. (13), with `change`.
VectorXd BandSystem::changeOfFlux(const BandVectors& slopes, const VectorXd& change) const {
  VectorXd flux = VectorXd::Zero(change.size());
  for (size_t k = 0; k < bands_.size(); ++k) {
    const VectorXd emitted = slopes[k].cwiseProduct(change);
    flux += emitted - emissivities_[k].cwiseProduct(solveRoughly(k, closed_.pairs * emitted));
  }
  for (Index i = 0; i < flux.size(); ++i)
    if (!isFree(i)) flux[i] = 0;
  return flux;
}

// Solves for the change of temperatures by BiCGSTAB (H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992), since
// the matrix of several bands is not symmetric. The preconditioner is the change of each row's emission.
VectorXd BandSystem::solveNewton(const VectorXd& right_side) const {
  const Index n = right_side.size();
  BandVectors slopes;
  VectorXd own = VectorXd::Zero(n);
  for (size_t k = 0; k < bands_.size(); ++k) own += slopes.emplace_back(slope(k));
  const VectorXd scale = own.unaryExpr([](double value) { return value > 0 ? 1 / value : 0.0; });
  const auto apply = [&](const VectorXd& y) { return changeOfFlux(slopes, scale.cwiseProduct(y)); };
  VectorXd y = VectorXd::Zero(n), residual = right_side, direction = residual;
  const VectorXd shadow = residual;
  const double goal = kInnerResidual * right_side.norm();
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

// Throws for a row that would have to emit less than nothing; called after Newton's method has failed.
void BandSystem::refuseNegativeEmission(const std::vector<std::string>& names) const {
  for (Index i = 0; i < temperatures_.size(); ++i) {
    if (!isFree(i)) continue;
    double emitted = *enclosure_.materials[static_cast<size_t>(i)].heat_flux;
    for (size_t k = 0; k < bands_.size(); ++k) emitted += emissivities_[k][i] * (irradiations_[k][i] + shifts_[k]);
    if (emitted < 0)
      throw Error(ErrorCode::bad_input,
                  fmt::format("'{}' would have to emit {:.4g} W/m2, less than nothing: its heat flux takes more than "
                              "arrives; lower it",
                              names[static_cast<size_t>(i)], emitted));
  }
}

void BandSystem::solve(const std::vector<std::string>& names) {
  if (std::ranges::find(is_free_, true) == is_free_.end()) return findIrradiations();
  guessTemperatures();
  findIrradiations();
  VectorXd off = excess();
  for (int step = 0; step < kMostSteps; ++step) {
    double scale = 0;
    for (Index i = 0; i < off.size(); ++i) {
      double emitted = isFree(i) ? std::abs(*enclosure_.materials[static_cast<size_t>(i)].heat_flux) : 0;
      for (size_t k = 0; k < bands_.size(); ++k)
        emitted += emissivities_[k][i] * bandPower(bands_[k], temperatures_[i]);
      scale = std::max(scale, emitted);
    }
    const double size = off.lpNorm<Eigen::Infinity>();
    if (size <= kSolved * scale) return;
    const VectorXd before = temperatures_, change = solveNewton(-off);
    const double norm = off.norm();
    double share = 1;
    for (int halving = 0; halving < kMostHalvings; ++halving, share /= 2) {
      temperatures_ = (before + share * change).cwiseMax(kLargestFall * before);
      findIrradiations();
      off = excess();
      if (off.norm() < norm) break;
    }
    if (!(off.norm() < norm)) {  // rounding prevents smaller residuals
      if (size <= kSolvedAtRounding * scale) return;
      break;
    }
  }
  refuseNegativeEmission(names);
  throw Error(ErrorCode::limit,
              "Newton's method did not find the temperatures of rows with given heat fluxes; give some of them "
              "temperatures");
}

BandSystem::Response BandSystem::respond(const BandVectors& disturbances) const {
  Response response{VectorXd::Zero(temperatures_.size()), {}};
  VectorXd flux = VectorXd::Zero(temperatures_.size());
  for (size_t k = 0; k < bands_.size(); ++k) {
    response.irradiation.push_back(solveRoughly(k, disturbances[k]));
    flux += emissivities_[k].cwiseProduct(response.irradiation[k]);
  }
  for (Index i = 0; i < flux.size(); ++i)
    if (!isFree(i)) flux[i] = 0;
  if (!(flux.norm() > 0)) return response;
  response.temperature = solveNewton(flux);
  for (size_t k = 0; k < bands_.size(); ++k)
    response.irradiation[k] += solveRoughly(k, closed_.pairs * slope(k).cwiseProduct(response.temperature));
  return response;
}

}  // namespace viewpeel
