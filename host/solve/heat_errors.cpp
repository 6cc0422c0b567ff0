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
                       const VectorXd& radiosity, const Outside& outside, uint32_t most_exact_rows)
    : closed_(closed), outside_(outside), radiosity_(radiosity) {
  sources_.reserve(measured.entries().size());
  // A row loses what its pair gains: from its environment if that is the rest of the row, else from its diagonal.
  const auto taken = [&](uint32_t row) {
    return closed.environment_is_rest[row] ? outside.power[row] : radiosity[row];
  };
  const auto lostBy = [&](uint32_t row, double error) { return closed.environment_is_rest[row] ? -error : 0.0; };
  for (const FormFactors::Entry& entry : measured.entries()) {
    const double error = entry.errorInSums();
    const auto [i, j] = std::pair(entry.i, entry.j);
    if (!(error > 0) || j == kLeak) continue;
    const double margin = entry.margin() / (error * error);
    if (j == kEnvironment) {
      if (!closed.is_open || closed.environment_is_rest[i]) continue;
      sources_.push_back({i, i, error * (outside.power[i] - radiosity[i]), 0, error, 0, margin});
      continue;
    }
    if (i == j) {
      sources_.push_back({i, i, error * (radiosity[i] - taken(i)), 0, lostBy(i, error), 0, margin});
      continue;
    }
    sources_.push_back({i, j, error * (radiosity[j] - taken(i)), error * (radiosity[i] - taken(j)), lostBy(i, error),
                        lostBy(j, error), margin});
  }
  if (sources_.empty() && outside.up_errors.empty()) return;
  if (closed.areas.size() <= most_exact_rows) {
    inverse_ = irradiation.inverse();
    return;
  }
  margins_.resize(static_cast<size_t>(closed.areas.size()));
  for (const Source& source : sources_)
    for (const auto& [row, change] : {std::pair(source.i, source.of_i), std::pair(source.j, source.of_j)})
      margins_[row] = std::max(margins_[row], source.margin * change * change);
  const size_t columns = kProbes + outside.up_errors.size();
  probes_.resize(closed.areas.size(), static_cast<Eigen::Index>(columns));
  to_environment_ = Eigen::MatrixXd::Zero(probes_.rows(), probes_.cols());
  shareOut(std::min<size_t>(threadCount(), columns), columns, 1, [&](size_t, size_t probe) {
    const auto column = static_cast<Eigen::Index>(probe);
    if (probe >= kProbes) {
      probes_.col(column) =
          irradiation.solveRoughly((outside.up_power - outside.down_power) * outside.up_errors[probe - kProbes]);
      return;
    }
    Random random(kProbeSeed, probe);
    VectorXd disturbance = VectorXd::Zero(closed.areas.size());
    uint64_t signs = 0;
    for (size_t k = 0; k < sources_.size(); ++k) {
      signs = k % 64 == 0 ? random.word() : signs >> 1;
      const double sign = signs & 1 ? 1 : -1;
      const Source& source = sources_[k];
      disturbance[source.i] += sign * source.of_i;
      disturbance[source.j] += sign * source.of_j;
      to_environment_(source.i, column) += sign * source.x_ie;
      to_environment_(source.j, column) += sign * source.x_je;
    }
    probes_.col(column) = irradiation.solveRoughly(disturbance);
  });
}

double HeatErrors::rootOfSquares(const Functional& functional) const {
  double squares = 0, largest_margin = 0;
  for (const Source& source : sources_) {
    const double change = functional.adjoint[source.i] * source.of_i + functional.adjoint[source.j] * source.of_j +
                          functional.of_environment[source.i] * source.x_ie +
                          functional.of_environment[source.j] * source.x_je;
    squares += change * change;
    largest_margin = std::max(largest_margin, source.margin * change * change);
  }
  squares += largest_margin;
  const double jump = outside_.up_power - outside_.down_power;
  for (const VectorXd& errors : outside_.up_errors)
    squares += std::pow(jump * functional.adjoint.dot(errors) + functional.of_up.dot(errors), 2);
  return std::sqrt(squares);
}

double HeatErrors::standardError(const std::vector<Term>& terms) const {
  const Eigen::Index n = closed_.areas.size();
  if (inverse_.size() > 0) {
    Functional functional{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n)};
    for (const Term& term : terms) functional.adjoint += term.factor * inverse_.row(term.row).transpose();
    return rootOfSquares(functional);
  }
  if (probes_.size() == 0) return 0;
  VectorXd changes = VectorXd::Zero(probes_.cols());
  double largest_margin = 0;
  for (const Term& term : terms) {
    changes += term.factor * probes_.row(term.row).transpose();
    largest_margin = std::max(largest_margin, std::pow(term.factor / closed_.areas[term.row], 2) * margins_[term.row]);
  }
  return std::sqrt(changes.head(kProbes).squaredNorm() / kProbes +
                   changes.tail(changes.size() - kProbes).squaredNorm() + largest_margin);
}

// The heat flow to a part p of the environment is sum_i x_ip (B_i - B_p). x_ip is row i's exchange area with the part,
// B_p the part's emissive power, and B = source + reflectivity H the radiosities of rows.
HeatErrors::Functional HeatErrors::environmentFlow(const VectorXd& reflectivity, Part part) const {
  const VectorXd ones = VectorXd::Ones(radiosity_.size());
  const VectorXd from_up = radiosity_ - outside_.up_power * ones, from_down = radiosity_ - outside_.down_power * ones;
  const VectorXd down_share = ones - outside_.up_share;
  const auto flow = [&](const VectorXd& share, const VectorXd& of_environment, const VectorXd& of_up) {
    return Functional{closed_.environment.cwiseProduct(share).cwiseProduct(reflectivity), of_environment, of_up};
  };
  if (part == Part::up) return flow(outside_.up_share, outside_.up_share.cwiseProduct(from_up), from_up);
  if (part == Part::down) return flow(down_share, down_share.cwiseProduct(from_down), -from_down);
  return flow(ones, radiosity_ - outside_.power, from_up - from_down);
}

double HeatErrors::environmentError(const VectorXd& reflectivity, Part part) const {
  Functional functional = environmentFlow(reflectivity, part);
  if (inverse_.size() > 0) {
    functional.adjoint = inverse_.transpose() * functional.adjoint;
    return rootOfSquares(functional);
  }
  if (probes_.size() == 0) return 0;
  VectorXd changes = probes_.transpose() * functional.adjoint + to_environment_.transpose() * functional.of_environment;
  VectorXd of_parts = changes.tail(changes.size() - kProbes);
  for (Eigen::Index r = 0; r < of_parts.size(); ++r)
    of_parts[r] += functional.of_up.dot(outside_.up_errors[static_cast<size_t>(r)]);
  return std::sqrt(changes.head(kProbes).squaredNorm() / kProbes + of_parts.squaredNorm());
}

}  // namespace viewpeel
