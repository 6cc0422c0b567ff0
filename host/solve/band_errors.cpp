#include "solve/band_errors.h"

#include <cmath>

namespace viewpeel {

using Eigen::Index;
using Eigen::VectorXd;

BandErrors::BandErrors(const ClosedExchange& closed, const BandState& state, size_t columns, size_t weighted,
                       double weight)
    : closed_(closed), state_(state), weighted_(static_cast<Index>(weighted)), weight_(weight) {
  const auto count = static_cast<Index>(columns);
  changes_.assign(kFlux + 1, Changes::Zero(closed.areas.size(), count));
  to_up_ = to_down_ = VectorXd::Zero(count);
  for (size_t k = 0; k < state.bandCount(); ++k) radiosities_.push_back(state.radiosity(k));
}

void BandErrors::put(size_t place, const BandDisturbance& disturbance, const BandResponse& response) {
  const auto column = static_cast<Index>(place);
  const Index n = closed_.areas.size();
  changes_[kTemperature].col(column) = response.temperature;
  const VectorXd ones = VectorXd::Ones(n), up = closed_.environment.cwiseProduct(state_.outside[0].up_share);
  const VectorXd down = closed_.environment - up;
  for (size_t k = 0; k < state_.bandCount(); ++k) {
    VectorXd emission(n);
    for (Index i = 0; i < n; ++i)
      emission[i] = state_.emissivities[k][i] * state_.powerSlope(k, state_.temperatures[i]) * response.temperature[i];
    const VectorXd absorbed = state_.emissivities[k].cwiseProduct(response.irradiation[k]);
    const VectorXd radiosity = emission + response.irradiation[k] - absorbed;
    changes_[kEmission].col(column) += emission;
    changes_[kIrradiation].col(column) += response.irradiation[k];
    changes_[kRadiosity].col(column) += radiosity;
    changes_[kFlux].col(column) += emission - absorbed;
    const Outside& outside = state_.outside[k];
    to_up_[column] += up.dot(radiosity) + disturbance.up.dot(radiosities_[k] - outside.up_power * ones);
    to_down_[column] += down.dot(radiosity) +
                        (disturbance.environment - disturbance.up).dot(radiosities_[k] - outside.down_power * ones);
  }
}

double BandErrors::rootOfSquares(const VectorXd& changes) const {
  return std::sqrt(weight_ * changes.head(weighted_).squaredNorm() +
                   changes.tail(changes.size() - weighted_).squaredNorm());
}

double BandErrors::standardError(Answer answer, const std::vector<Term>& terms) const {
  VectorXd changes = VectorXd::Zero(changes_[answer].cols());
  for (const Term& term : terms) changes += term.factor * changes_[answer].row(term.row).transpose();
  return rootOfSquares(changes);
}

}  // namespace viewpeel
