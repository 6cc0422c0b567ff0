#include "solve/carry_pair_errors.h"

#include <algorithm>

#include "directions/random.h"
#include "solve/heat_errors.h"
#include "threads.h"

namespace viewpeel {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr uint64_t kBandProbeSeed = 0x62616E6473;

// A Disturber adds errors of exchange areas to disturbances, band by band: docs/solve.md, eq. (7).
class Disturber {
 public:
  Disturber(const ClosedExchange& closed, const BandState& state) : closed_(closed), state_(state) {
    for (size_t k = 0; k < state.bandCount(); ++k) radiosities_.push_back(state.radiosity(k));
  }

  bool counts(const FormFactors::Entry& entry) const {
    if (!(entry.exchange_area.standard_error > 0) || entry.j == kLeak) return false;
    return entry.j != kEnvironment || (closed_.is_open && !closed_.environment_is_rest[entry.i]);
  }
  void add(const FormFactors::Entry& entry, double sign, BandDisturbance& sum) const {
    const double error = sign * entry.exchange_area.standard_error;
    if (entry.j == kEnvironment) {
      sum.environment[entry.i] += error;
      sum.up[entry.i] += error * state_.outside[0].up_share[entry.i];
      for (size_t k = 0; k < state_.bandCount(); ++k)
        sum.of_bands[k][entry.i] += error * (state_.outside[k].power[entry.i] - radiosities_[k][entry.i]);
      return;
    }
    gain(entry.i, entry.j, error, sum);
    if (entry.i != entry.j) gain(entry.j, entry.i, error, sum);
  }

 private:
  // Adds what follows where a row exchanges `error` more with another row. Its environment loses as much if it is the
  // rest of the row (environment_is_rest), else the row's exchange with itself does.
  void gain(uint32_t row, uint32_t other, double error, BandDisturbance& sum) const {
    const bool is_rest = closed_.environment_is_rest[row];
    if (is_rest) {
      sum.environment[row] -= error;
      sum.up[row] -= error * state_.outside[0].up_share[row];
    }
    for (size_t k = 0; k < state_.bandCount(); ++k)
      sum.of_bands[k][row] +=
          error * (radiosities_[k][other] - (is_rest ? state_.outside[k].power[row] : radiosities_[k][row]));
  }

  const ClosedExchange& closed_;
  const BandState& state_;
  BandVectors radiosities_;
};

}  // namespace

BandErrors carryPairErrors(const FormFactors& measured, const ClosedExchange& closed, const BandSystem& system,
                           size_t most_sources) {
  const BandState& state = system.state();
  const Index n = closed.areas.size();
  const size_t bands = state.bandCount();
  const Disturber disturber(closed, state);
  std::vector<FormFactors::Entry> sources;
  std::ranges::copy_if(measured.entries(), std::back_inserter(sources),
                       [&](const FormFactors::Entry& entry) { return disturber.counts(entry); });
  const bool has_probes = sources.size() > most_sources;
  const size_t of_pairs = has_probes ? kProbes : sources.size();
  const std::vector<VectorXd>& up_errors = state.outside[0].up_errors;
  const size_t columns = of_pairs + up_errors.size();

  const auto disturb = [&](size_t column) {
    BandDisturbance sum(n, bands);
    if (column >= of_pairs) {
      sum.up = up_errors[column - of_pairs];
      for (size_t k = 0; k < bands; ++k)
        sum.of_bands[k] = (state.outside[k].up_power - state.outside[k].down_power) * sum.up;
    } else if (!has_probes) {
      disturber.add(sources[column], 1, sum);
    } else {
      Random random(kBandProbeSeed, column);
      uint64_t signs = 0;
      for (size_t s = 0; s < sources.size(); ++s) {
        signs = s % 64 == 0 ? random.word() : signs >> 1;
        disturber.add(sources[s], signs & 1 ? 1 : -1, sum);
      }
    }
    return sum;
  };
  BandErrors errors(closed, state, columns, of_pairs, has_probes ? 1.0 / kProbes : 1);
  shareOut(std::min<size_t>(threadCount(), std::max<size_t>(columns, 1)), columns, 1, [&](size_t, size_t column) {
    const BandDisturbance disturbance = disturb(column);
    errors.put(column, disturbance, system.respond(disturbance.of_bands));
  });
  return errors;
}

}  // namespace viewpeel
