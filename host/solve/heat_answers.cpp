#include "solve/heat_answers.h"

#include <cmath>

#include <fmt/format.h>

#include "solve/sum_rows.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

double temperatureOf(double emissive_power) { return std::pow(emissive_power / kStefanBoltzmann, 0.25); }

// Returns a temperature with its standard error. Since E = s T^4, dT = dE / (4 s T^3), s the Stefan-Boltzmann constant.
Measured temperatureOf(const Measured& emissive_power) {
  const double temperature = temperatureOf(emissive_power.value);
  const double slope = 4 * kStefanBoltzmann * std::pow(temperature, 3);
  return {temperature, emissive_power.standard_error == 0 ? 0 : emissive_power.standard_error / slope};
}

class Answers {
 public:
  Answers(const HeatState& state, const ClosedExchange& closed, const Outside& outside, const CarriedErrors& errors,
          const AnswerRows& answers, const VectorXd& bounds)
      : ids_(state.ids),
        enclosure_(state.enclosure),
        closed_(closed),
        shift_(state.shift),
        outside_(outside),
        reflectivity_(state.reflectivity),
        h_(state.irradiation),
        b_(state.radiosity),
        errors_(errors),
        answers_(answers),
        bounds_(bounds) {}

  HeatSolution solution() const {
    HeatSolution found;
    found.is_open = closed_.is_open;
    found.largest_lack = closed_.largest_lack;
    found.lacking_row = ids_.count() ? ids_.names[closed_.lacking_row] : "";
    for (size_t k = 0; k < answers_.rows.size(); ++k)
      found.rows.push_back(answerOf(answers_.names[k], answers_.rows[k]));
    for (size_t k = 0; k < answers_.surfaces.size(); ++k)
      if (!answers_.surfaces[k].empty())
        found.surfaces.push_back(answerOf(enclosure_.surface_names[k], answers_.surfaces[k]));
    found.to_environment = {closed_.environment.dot(b_ - outside_.power), errors_.environmentError(reflectivity_)};
    if (closed_.is_open && enclosure_.sky_and_ground) {
      using Part = CarriedErrors::Part;
      const VectorXd to_up = closed_.environment.cwiseProduct(outside_.up_share);
      const VectorXd to_down = closed_.environment - to_up, ones = VectorXd::Ones(b_.size());
      found.to_up = {to_up.dot(b_ - outside_.up_power * ones), errors_.environmentError(reflectivity_, Part::up)};
      found.to_down = {to_down.dot(b_ - outside_.down_power * ones),
                       errors_.environmentError(reflectivity_, Part::down)};
    }
    balance(found);
    return found;
  }

 private:
  // Returns the emissive power of a row less HeatState::shift, W/m2; of a reflector, which emits nothing, its radiosity
  // less the shift.
  double powerOf(uint32_t i) const {
    const Material& material = enclosure_.materials[i];
    return material.temperature       ? emissivePower(*material.temperature) - shift_
           : material.emissivity == 0 ? h_[i]
                                      : h_[i] + *material.heat_flux / material.emissivity;
  }
  double fluxOf(uint32_t i) const {
    const Material& material = enclosure_.materials[i];
    return material.temperature ? material.emissivity * (powerOf(i) - h_[i]) : *material.heat_flux;
  }
  // Returns the derivative of a row's heat flux with respect to its irradiation; its temperature or heat flux is given.
  double fluxSlope(uint32_t i) const {
    return enclosure_.materials[i].temperature ? -enclosure_.materials[i].emissivity : 0.0;
  }
  double powerSlope(uint32_t i) const { return enclosure_.materials[i].temperature ? 0 : 1; }

  Measured temperatureAt(double power, double error, const std::string& name) const {
    const double emissive_power = power + shift_;
    if (!(emissive_power >= 0) && emissive_power > -1e-9 * (std::abs(power) + shift_)) return {0, 0};  // by rounding
    if (!(emissive_power >= 0))
      throw Error(ErrorCode::bad_input,
                  fmt::format("'{}' would have to emit {:.4g} W/m2, less than nothing: its heat flux takes more than "
                              "arrives; lower it",
                              name, emissive_power));
    return temperatureOf(Measured{emissive_power, error});
  }

  HeatRow rowOf(uint32_t i) const {
    const Material& material = enclosure_.materials[i];
    const double error = errors_.standardError({{i, 1}}), area = ids_.areas[i];
    HeatRow row{ids_.names[i], area, material.emissivity};
    row.temperature =
        material.temperature ? Measured{*material.temperature, 0} : temperatureAt(powerOf(i), error, ids_.names[i]);
    row.radiosity = {b_[i] + shift_, reflectivity_[i] * error};
    row.irradiation = {h_[i] + shift_, error};
    row.heat_flux = {fluxOf(i), std::abs(fluxSlope(i)) * error};
    row.heat_flow = {area * row.heat_flux.value, area * row.heat_flux.standard_error};
    if (bounds_.size() > 0) {
      const double bound = bounds_[i], of_flux = std::abs(fluxSlope(i)) * bound;
      row.bounds = {temperatureBound(row.temperature.value, powerSlope(i) * bound), reflectivity_[i] * bound, bound,
                    of_flux, area * of_flux};
    }
    return row;
  }

  // Returns the largest error of a temperature whose emissive power is off by at most `bound`.
  static double temperatureBound(double temperature, double bound) {
    if (!(bound > 0)) return 0;
    const double power = emissivePower(temperature);
    return std::max(temperatureOf(power + bound) - temperature,
                    temperature - temperatureOf(std::max(0.0, power - bound)));
  }

  HeatRow sumRows(const std::string& name, const std::vector<uint32_t>& rows) const {
    HeatRow sum{name, 0, 0};
    double emitting = 0;
    for (const uint32_t i : rows) {
      sum.area += ids_.areas[i];
      emitting += ids_.areas[i] * enclosure_.materials[i].emissivity;
    }
    sum.emissivity = emitting / sum.area;
    std::vector<CarriedErrors::Term> irradiations, radiosities, fluxes, powers;
    double power = 0, radiosity = 0, irradiation = 0, flow = 0;
    std::optional<double> given;  // the temperature that all have
    for (const uint32_t i : rows) {
      const double share = ids_.areas[i] / sum.area,
                   emitted = ids_.areas[i] * enclosure_.materials[i].emissivity / emitting;
      irradiations.push_back({i, share});
      radiosities.push_back({i, share * reflectivity_[i]});
      fluxes.push_back({i, share * fluxSlope(i)});
      powers.push_back({i, emitted * powerSlope(i)});
      irradiation += share * h_[i];
      radiosity += share * b_[i];
      power += emitted * powerOf(i);
      flow += ids_.areas[i] * fluxOf(i);
      if (enclosure_.materials[i].emissivity == 0) continue;  // a reflector has no temperature
      if (&i == &rows.front()) given = enclosure_.materials[i].temperature;
      else if (given != enclosure_.materials[i].temperature) given.reset();
    }
    sum.temperature = given ? Measured{*given, 0} : temperatureAt(power, errors_.standardError(powers), name);
    sum.radiosity = {radiosity + shift_, errors_.standardError(radiosities)};
    sum.irradiation = {irradiation + shift_, errors_.standardError(irradiations)};
    sum.heat_flux = {flow / sum.area, errors_.standardError(fluxes)};
    sum.heat_flow = {flow, sum.area * sum.heat_flux.standard_error};
    if (bounds_.size() > 0) {
      const auto boundOf = [&](const std::vector<CarriedErrors::Term>& terms) {
        double bound = 0;
        for (const CarriedErrors::Term& term : terms)
          bound += term.factor == 0 ? 0 : std::abs(term.factor) * bounds_[term.row];
        return bound;
      };
      const double of_flux = boundOf(fluxes);
      sum.bounds = {temperatureBound(sum.temperature.value, boundOf(powers)), boundOf(radiosities),
                    boundOf(irradiations), of_flux, sum.area * of_flux};
    }
    return sum;
  }

  HeatRow answerOf(const std::string& name, const std::vector<uint32_t>& rows) const {
    if (rows.size() > 1) return sumRows(name, rows);
    HeatRow row = rowOf(rows.front());
    row.name = name;
    return row;
  }

  const Ids& ids_;
  const Enclosure& enclosure_;
  const ClosedExchange& closed_;
  const double shift_;
  const Outside& outside_;
  const VectorXd &reflectivity_, &h_, &b_;
  const CarriedErrors& errors_;
  const AnswerRows& answers_;
  const VectorXd& bounds_;  // of irradiations; empty without intervals
};

}  // namespace

double emissivePower(double temperature) { return kStefanBoltzmann * std::pow(temperature, 4); }

double chooseShift(bool is_open, const Enclosure& enclosure) {
  if (is_open && enclosure.sky_and_ground) return emissivePower(enclosure.sky_and_ground->up);
  if (is_open && enclosure.environment_temperature) return emissivePower(*enclosure.environment_temperature);
  for (const Material& material : enclosure.materials)
    if (material.temperature) return emissivePower(*material.temperature);
  return 0;
}

HeatState::HeatState(const Ids& rows, const Enclosure& of_rows, bool is_open)
    : ids(rows),
      enclosure(of_rows),
      shift(chooseShift(is_open, of_rows)),
      source(rows.count()),
      reflectivity(rows.count()) {
  for (uint32_t i = 0; i < rows.count(); ++i) {
    const Material& material = enclosure.materials[i];
    source[i] = material.temperature ? material.emissivity * (emissivePower(*material.temperature) - shift)
                                     : *material.heat_flux;
    reflectivity[i] = material.temperature ? 1 - material.emissivity : 1;
  }
}

void HeatState::take(const VectorXd& irradiations) {
  irradiation = irradiations;
  radiosity = source + reflectivity.cwiseProduct(irradiation);
}

AnswerRows answerRows(const Ids& ids, const Enclosure& enclosure) {
  AnswerRows answers{ids.names, {}, rowsOfSurfaces(ids, enclosure.surface_names.size())};
  for (uint32_t i = 0; i < ids.count(); ++i) answers.rows.push_back({i});
  return answers;
}

HeatSolution answerHeat(const HeatState& state, const ClosedExchange& closed, const Outside& outside,
                        const CarriedErrors& errors, const AnswerRows& answers, const VectorXd& bounds) {
  return Answers(state, closed, outside, errors, answers, bounds).solution();
}

}  // namespace viewpeel
