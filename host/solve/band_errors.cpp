#include "solve/band_errors.h"

namespace viewpeel {

using Eigen::Index;
using Eigen::VectorXd;

BandErrors::BandErrors(const ClosedExchange& closed, const BandState& state, size_t columns, size_t weighted,
                       double weight)
    : closed_(closed), state_(state), weighted_(static_cast<Index>(weighted)), weight_(weight) {
  const auto count = static_cast<Index>(columns);
  changes_.assign(kFlux + 1, Changes::Zero(closed.areas.size(), count));
  of_rows_.assign(kFlux + 1, VectorXd::Zero(closed.areas.size()));
  to_up_ = to_down_ = VectorXd::Zero(count);
  for (size_t k = 0; k < state.bandCount(); ++k) radiosities_.push_back(state.radiosity(k));
}

std::vector<VectorXd> BandErrors::changesOf(const BandResponse& response) const {
  const Index n = closed_.areas.size();
  std::vector<VectorXd> changes(kFlux + 1, VectorXd::Zero(n));
  changes[kTemperature] = response.temperature;
  for (size_t k = 0; k < state_.bandCount(); ++k) {
    VectorXd emission(n);
    for (Index i = 0; i < n; ++i)
      emission[i] = state_.emissivities[k][i] * state_.powerSlope(k, state_.temperatures[i]) * response.temperature[i];
    const VectorXd absorbed = state_.emissivities[k].cwiseProduct(response.irradiation[k]);
    changes[kEmission] += emission;
    changes[kIrradiation] += response.irradiation[k];
    changes[kRadiosity] += emission + response.irradiation[k] - absorbed;
    changes[kFlux] += emission - absorbed;
  }
  return changes;
}

void BandErrors::put(size_t place, const BandDisturbance& disturbance, const BandResponse& response) {
  const auto column = static_cast<Index>(place);
  const std::vector<VectorXd> changes = changesOf(response);
  for (size_t answer = 0; answer < changes.size(); ++answer) changes_[answer].col(column) = changes[answer];
  const VectorXd ones = VectorXd::Ones(closed_.areas.size()),
                 up = closed_.environment.cwiseProduct(state_.outside[0].up_share), down = closed_.environment - up;
  to_up_[column] = up.dot(changes[kRadiosity]);
  to_down_[column] = down.dot(changes[kRadiosity]);
  for (size_t k = 0; k < state_.bandCount(); ++k) {
    const Outside& outside = state_.outside[k];
    to_up_[column] += disturbance.up.dot(radiosities_[k] - outside.up_power * ones);
    to_down_[column] += (disturbance.environment - disturbance.up).dot(radiosities_[k] - outside.down_power * ones);
  }
}

void BandErrors::putOfRows(const BandResponse& response) { of_rows_ = changesOf(response); }

double BandErrors::weighedSquares(const VectorXd& changes) const {
  return weight_ * changes.head(weighted_).squaredNorm() + changes.tail(changes.size() - weighted_).squaredNorm();
}

double BandErrors::standardError(Answer answer, const std::vector<Term>& terms) const {
  VectorXd changes = VectorXd::Zero(changes_[answer].cols());
  double of_rows = 0;  // squares
  for (const Term& term : terms) {
    changes += term.factor * changes_[answer].row(term.row).transpose();
    of_rows += std::pow(term.factor * of_rows_[answer][term.row], 2);
  }
  return std::sqrt(weighedSquares(changes) + of_rows);
}

}  // namespace viewpeel
