#include "solve/band_answers.h"

#include <algorithm>
#include <cmath>

#include "solve/sum_rows.h"

namespace viewpeel {
namespace {

using Eigen::VectorXd;
using Term = BandErrors::Term;

constexpr int kMostBisections = 200;

class BandAnswers {
 public:
  BandAnswers(const Ids& ids, const BandState& state, const ClosedExchange& closed, const BandErrors& errors)
      : ids_(ids), enclosure_(state.enclosure), closed_(closed), state_(state), errors_(errors) {}

  HeatSolution solution() const {
    HeatSolution found;
    found.is_open = closed_.is_open;
    found.largest_lack = closed_.largest_lack;
    found.lacking_row = ids_.count() ? ids_.names[closed_.lacking_row] : "";
    for (uint32_t i = 0; i < ids_.count(); ++i) found.rows.push_back(sumRows(ids_.names[i], {i}));
    const auto rows = rowsOfSurfaces(ids_, enclosure_.surface_names.size());
    for (size_t k = 0; k < rows.size(); ++k)
      if (!rows[k].empty()) found.surfaces.push_back(sumRows(enclosure_.surface_names[k], rows[k]));
    addOutside(found);
    balance(found);
    return found;
  }

 private:
  void addOutside(HeatSolution& found) const {
    double up = 0, down = 0;
    for (size_t k = 0; k < state_.bandCount(); ++k) {
      const Outside& outside = state_.outside[k];
      const VectorXd to_up = closed_.environment.cwiseProduct(outside.up_share);
      const VectorXd radiosity = state_.radiosity(k), ones = VectorXd::Ones(radiosity.size());
      up += to_up.dot(radiosity - outside.up_power * ones);
      down += (closed_.environment - to_up).dot(radiosity - outside.down_power * ones);
    }
    found.to_environment = {up + down, errors_.toEnvironment()};
    if (!closed_.is_open || !enclosure_.sky_and_ground) return;
    found.to_up = {up, errors_.toUp()};
    found.to_down = {down, errors_.toDown()};
  }

  // An Emission is what some rows emit at one temperature: power over the area of all rows, W/m2, and its derivative
  // with respect to the temperature, slope.
  struct Emission {
    double power = 0, slope = 0;
  };
  Emission emissionAt(const VectorXd& emissivities, double temperature) const {
    Emission emission;
    for (size_t k = 0; k < state_.bandCount(); ++k) {
      emission.power += emissivities[static_cast<Eigen::Index>(k)] * state_.power(k, temperature);
      emission.slope += emissivities[static_cast<Eigen::Index>(k)] * state_.powerSlope(k, temperature);
    }
    return emission;
  }
  // Returns the temperature at which rows of these mean emissivities emit this power. Emission grows with the
  // temperature, so bisection finds it.
  double temperatureOf(const VectorXd& emissivities, double power, double low, double high) const {
    for (int turn = 0; turn < kMostBisections && low < high; ++turn) {
      const double middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      (emissionAt(emissivities, middle).power < power ? low : high) = middle;
    }
    return high;
  }

  HeatRow sumRows(const std::string& name, const std::vector<uint32_t>& rows) const {
    HeatRow sum{name, 0, 0};
    for (const uint32_t i : rows) sum.area += ids_.areas[i];
    std::vector<Term> shares;
    VectorXd emissivities = VectorXd::Zero(static_cast<Eigen::Index>(state_.bandCount()));
    double power = 0, coldest = INFINITY, hottest = 0;
    bool is_given = true;
    for (const uint32_t i : rows) {
      const double share = ids_.areas[i] / sum.area, temperature = state_.temperatures[i];
      const Material& material = enclosure_.materials[i];
      shares.push_back({i, share});
      coldest = std::min(coldest, temperature), hottest = std::max(hottest, temperature);
      is_given =
          is_given && material.temperature && material.temperature == enclosure_.materials[rows.front()].temperature;
      for (size_t k = 0; k < state_.bandCount(); ++k) {
        const double emissivity = state_.emissivities[k][i], arriving = state_.irradiations[k][i];
        const double emitted = emissivity * state_.power(k, temperature);
        emissivities[static_cast<Eigen::Index>(k)] += share * emissivity;
        power += share * emitted;
        sum.irradiation.value += share * (arriving + state_.shifts[k]);
        sum.radiosity.value += share * (emitted + (1 - emissivity) * arriving + state_.shifts[k]);
        if (material.temperature) sum.heat_flux.value += share * (emitted - emissivity * arriving);
      }
      if (!material.temperature) sum.heat_flux.value += share * *material.heat_flux;
    }
    const double temperature = coldest == hottest ? hottest : temperatureOf(emissivities, power, coldest, hottest);
    const double slope = emissionAt(emissivities, temperature).slope;
    sum.temperature = {temperature, is_given || !(slope > 0) ? 0 : error(BandErrors::kEmission, shares) / slope};
    sum.emissivity = meanEmissivity(emissivities, temperature);
    sum.radiosity.standard_error = error(BandErrors::kRadiosity, shares);
    sum.irradiation.standard_error = error(BandErrors::kIrradiation, shares);
    std::vector<Term> of_flux;  // the shares of rows of given temperature, for heat fluxes of other rows have no error
    for (const Term& term : shares)
      if (enclosure_.materials[term.row].temperature) of_flux.push_back(term);
    sum.heat_flux.standard_error = error(BandErrors::kFlux, of_flux);
    sum.heat_flow = {sum.area * sum.heat_flux.value, sum.area * sum.heat_flux.standard_error};
    return sum;
  }
  double error(BandErrors::Answer answer, const std::vector<Term>& terms) const {
    return errors_.standardError(answer, terms);
  }

  // Returns the emissivity, averaged over black emission at the temperature.
  double meanEmissivity(const VectorXd& emissivities, double temperature) const {
    double emitted = 0, black = 0;
    for (size_t k = 0; k < state_.bandCount(); ++k) {
      const double power = state_.power(k, temperature) + state_.shifts[k];
      emitted += emissivities[static_cast<Eigen::Index>(k)] * power;
      black += power;
    }
    return black > 0 ? emitted / black : emissivities[emissivities.size() - 1];
  }

  const Ids& ids_;
  const Enclosure& enclosure_;
  const ClosedExchange& closed_;
  const BandState& state_;
  const BandErrors& errors_;
};

}  // namespace

HeatSolution answerBands(const Ids& ids, const BandState& state, const ClosedExchange& closed,
                         const BandErrors& errors) {
  return BandAnswers(ids, state, closed, errors).solution();
}

}  // namespace viewpeel
