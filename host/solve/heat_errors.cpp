#include "solve/heat_errors.h"

#include <algorithm>
#include <cmath>

#include "directions/random.h"
#include "threads.h"

namespace viewpeel {
namespace {

using Eigen::VectorXd;

constexpr uint64_t kProbeSeed = 0x736F6C7665;

}  // namespace

HeatErrors::HeatErrors(const FormFactors& measured, const ClosedExchange& closed, const Irradiation& irradiation,
                       const VectorXd& radiosity, uint32_t most_exact_rows)
    : closed_(closed) {
  sources_.reserve(measured.entries().size());
  // What a pair gains, the row's environment loses where it is the rest, else the row's own diagonal.
  const auto taken = [&](uint32_t row) { return closed.environment_is_rest[row] ? 0.0 : radiosity[row]; };
  const auto lostTo = [&](uint32_t row) { return closed.environment_is_rest[row] ? radiosity[row] : 0.0; };
  for (const FormFactors::Entry& entry : measured.entries()) {
    const double error = entry.exchange_area.standard_error;
    const auto [i, j] = std::pair(entry.i, entry.j);
    if (!(error > 0) || j == kLeak) continue;
    if (j == kEnvironment) {
      if (!closed.is_open || closed.environment_is_rest[i]) continue;
      sources_.push_back({i, i, -error * radiosity[i], 0, error * radiosity[i]});
      continue;
    }
    if (i == j) {
      const double gain = error * (radiosity[i] - taken(i));
      sources_.push_back({i, i, gain, 0, -error * lostTo(i)});
      continue;
    }
    sources_.push_back(
        {i, j, error * (radiosity[j] - taken(i)), error * (radiosity[i] - taken(j)), -error * (lostTo(i) + lostTo(j))});
  }
  if (sources_.empty()) return;
  if (closed.areas.size() <= most_exact_rows) {
    inverse_ = irradiation.inverse();
    return;
  }
  probes_.resize(closed.areas.size(), kProbes);
  to_environment_ = VectorXd::Zero(kProbes);
  shareOut(std::min<size_t>(threadCount(), kProbes), kProbes, 1, [&](size_t, size_t probe) {
    Random random(kProbeSeed, probe);
    VectorXd disturbance = VectorXd::Zero(closed.areas.size());
    uint64_t signs = 0;
    double outside = 0;
    for (size_t k = 0; k < sources_.size(); ++k) {
      signs = k % 64 == 0 ? random.word() : signs >> 1;
      const double sign = signs & 1 ? 1 : -1;
      disturbance[sources_[k].i] += sign * sources_[k].of_i;
      disturbance[sources_[k].j] += sign * sources_[k].of_j;
      outside += sign * sources_[k].to_environment;
    }
    const auto column = static_cast<Eigen::Index>(probe);
    to_environment_[column] = outside;
    probes_.col(column) = irradiation.solveRoughly(disturbance);
  });
}

double HeatErrors::rootOfSquares(const VectorXd& adjoint, bool of_environment) const {
  double squares = 0;
  for (const Source& source : sources_) {
    const double change = adjoint[source.i] * source.of_i + adjoint[source.j] * source.of_j +
                          (of_environment ? source.to_environment : 0);
    squares += change * change;
  }
  return std::sqrt(squares);
}

double HeatErrors::standardError(const std::vector<Term>& terms) const {
  if (sources_.empty()) return 0;
  if (inverse_.size() > 0) {
    VectorXd adjoint = VectorXd::Zero(closed_.areas.size());
    for (const Term& term : terms) adjoint += term.factor * inverse_.row(term.row).transpose();
    return rootOfSquares(adjoint, false);
  }
  VectorXd changes = VectorXd::Zero(kProbes);
  for (const Term& term : terms) changes += term.factor * probes_.row(term.row).transpose();
  return std::sqrt(changes.squaredNorm() / kProbes);
}

double HeatErrors::environmentError(const VectorXd& reflectivity) const {
  if (sources_.empty()) return 0;
  const VectorXd factors = closed_.environment.cwiseProduct(reflectivity);
  if (inverse_.size() > 0) return rootOfSquares(inverse_.transpose() * factors, true);
  const VectorXd changes = probes_.transpose() * factors + to_environment_;
  return std::sqrt(changes.squaredNorm() / kProbes);
}

}  // namespace viewpeel
