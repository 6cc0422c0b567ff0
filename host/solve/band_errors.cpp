#include "solve/band_errors.h"

#include <algorithm>
#include <cmath>

#include "directions/random.h"
#include "solve/heat_errors.h"
#include "threads.h"

namespace viewpeel {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr uint64_t kProbeSeed = 0x62616E6473;

// A Disturbance is the effect of errors of exchange areas. of_bands is the effect on A H_k of each band k, W. The other
// two are effects on each row's exchange area with the whole environment, and with its part above the horizon (up).
struct Disturbance {
  BandVectors of_bands;
  VectorXd environment, up;

  Disturbance(Index rows, size_t bands)
      : of_bands(bands, VectorXd::Zero(rows)), environment(VectorXd::Zero(rows)), up(VectorXd::Zero(rows)) {}
};

// A Disturber adds errors of exchange areas to disturbances, band by band: docs/solve.md, eq. (7).
class Disturber {
 public:
  Disturber(const ClosedExchange& closed, const BandSystem& system) : closed_(closed), system_(system) {
    for (size_t k = 0; k < system.bandCount(); ++k) radiosities_.push_back(system.radiosity(k));
  }
  const VectorXd& radiosity(size_t k) const { return radiosities_[k]; }

  bool counts(const FormFactors::Entry& entry) const {
    if (!(entry.exchange_area.standard_error > 0) || entry.j == kLeak) return false;
    return entry.j != kEnvironment || (closed_.is_open && !closed_.environment_is_rest[entry.i]);
  }
  void add(const FormFactors::Entry& entry, double sign, Disturbance& sum) const {
    const double error = sign * entry.exchange_area.standard_error;
    if (entry.j == kEnvironment) {
      sum.environment[entry.i] += error;
      sum.up[entry.i] += error * system_.outside(0).up_share[entry.i];
      for (size_t k = 0; k < system_.bandCount(); ++k)
        sum.of_bands[k][entry.i] += error * (system_.outside(k).power[entry.i] - radiosities_[k][entry.i]);
      return;
    }
    gain(entry.i, entry.j, error, sum);
    if (entry.i != entry.j) gain(entry.j, entry.i, error, sum);
  }

 private:
  // Adds what follows where a row exchanges `error` more with another row. Its environment loses as much if it is the
  // rest of the row (environment_is_rest), else the row's exchange with itself does.
  void gain(uint32_t row, uint32_t other, double error, Disturbance& sum) const {
    const bool is_rest = closed_.environment_is_rest[row];
    if (is_rest) {
      sum.environment[row] -= error;
      sum.up[row] -= error * system_.outside(0).up_share[row];
    }
    for (size_t k = 0; k < system_.bandCount(); ++k)
      sum.of_bands[k][row] +=
          error * (radiosities_[k][other] - (is_rest ? system_.outside(k).power[row] : radiosities_[k][row]));
  }

  const ClosedExchange& closed_;
  const BandSystem& system_;
  BandVectors radiosities_;
};

}  // namespace

BandErrors::BandErrors(const FormFactors& measured, const ClosedExchange& closed, const BandSystem& system,
                       size_t most_sources) {
  const Index n = closed.areas.size();
  const size_t bands = system.bandCount();
  const Disturber disturber(closed, system);
  std::vector<FormFactors::Entry> sources;
  std::ranges::copy_if(measured.entries(), std::back_inserter(sources),
                       [&](const FormFactors::Entry& entry) { return disturber.counts(entry); });
  const bool has_probes = sources.size() > most_sources;
  sources_ = has_probes ? kProbes : sources.size();
  weight_ = has_probes ? 1.0 / kProbes : 1;
  const std::vector<VectorXd>& up_errors = system.outside(0).up_errors;
  const size_t columns = sources_ + up_errors.size();
  changes_.assign(kFlux + 1, Eigen::MatrixXd::Zero(n, static_cast<Index>(columns)));
  to_up_ = to_down_ = VectorXd::Zero(static_cast<Index>(columns));

  const auto disturb = [&](size_t column) {
    Disturbance sum(n, bands);
    if (column >= sources_) {
      sum.up = up_errors[column - sources_];
      for (size_t k = 0; k < bands; ++k)
        sum.of_bands[k] = (system.outside(k).up_power - system.outside(k).down_power) * sum.up;
    } else if (!has_probes) {
      disturber.add(sources[column], 1, sum);
    } else {
      Random random(kProbeSeed, column);
      uint64_t signs = 0;
      for (size_t s = 0; s < sources.size(); ++s) {
        signs = s % 64 == 0 ? random.word() : signs >> 1;
        disturber.add(sources[s], signs & 1 ? 1 : -1, sum);
      }
    }
    return sum;
  };
  shareOut(std::min<size_t>(threadCount(), std::max<size_t>(columns, 1)), columns, 1, [&](size_t, size_t place) {
    const auto column = static_cast<Index>(place);
    const Disturbance disturbance = disturb(place);
    const BandSystem::Response response = system.respond(disturbance.of_bands);
    changes_[kTemperature].col(column) = response.temperature;
    const VectorXd& share = system.outside(0).up_share;
    for (size_t k = 0; k < bands; ++k) {
      VectorXd emission(n);
      for (Index i = 0; i < n; ++i)
        emission[i] =
            system.emissivity(k)[i] * system.powerSlope(k, system.temperatures()[i]) * response.temperature[i];
      const VectorXd absorbed = system.emissivity(k).cwiseProduct(response.irradiation[k]);
      const VectorXd radiosity = emission + response.irradiation[k] - absorbed;
      changes_[kEmission].col(column) += emission;
      changes_[kIrradiation].col(column) += response.irradiation[k];
      changes_[kRadiosity].col(column) += radiosity;
      changes_[kFlux].col(column) += emission - absorbed;
      const Outside& outside = system.outside(k);
      const VectorXd up = closed.environment.cwiseProduct(share), down = closed.environment - up;
      const VectorXd ones = VectorXd::Ones(n);
      to_up_[column] += up.dot(radiosity) + disturbance.up.dot(disturber.radiosity(k) - outside.up_power * ones);
      to_down_[column] +=
          down.dot(radiosity) +
          (disturbance.environment - disturbance.up).dot(disturber.radiosity(k) - outside.down_power * ones);
    }
  });
}

double BandErrors::rootOfSquares(const VectorXd& changes) const {
  const auto sources = static_cast<Index>(sources_);
  return std::sqrt(weight_ * changes.head(sources).squaredNorm() +
                   changes.tail(changes.size() - sources).squaredNorm());
}

double BandErrors::standardError(Answer answer, const std::vector<Term>& terms) const {
  VectorXd changes = VectorXd::Zero(changes_[answer].cols());
  for (const Term& term : terms) changes += term.factor * changes_[answer].row(term.row).transpose();
  return rootOfSquares(changes);
}

}  // namespace viewpeel
