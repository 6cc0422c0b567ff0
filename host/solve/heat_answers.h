// HeatAnswers go from irradiations to what users ask for: temperatures, heat fluxes and sums over surfaces, with their
// errors.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"
#include "solve/heat_errors.h"
#include "solve/outside.h"

namespace viewpeel {

// Returns the emissive power s T^4 of a black surface, W/m2, with the Stefan-Boltzmann constant s.
//   In: temperature: T, K
double emissivePower(double temperature);

// Returns the emissive power that is subtracted from all others, W/m2: that of the environment, of the sky, or of the
// first given temperature. Environment or sky then drop out of the equations.
double chooseShift(bool is_open, const Enclosure& enclosure);

// A HeatState has radiosities and irradiations of a grey enclosure less one emissive power, the shift, so that rows of
// nearly one temperature lose no digits.
struct HeatState {
  //   In: ids, enclosure: referred to; the enclosure's materials are sound
  HeatState(const Ids& ids, const Enclosure& enclosure, bool is_open);

  // Sets irradiations, and the radiosities that follow.
  void take(const Eigen::VectorXd& irradiations);

  const Ids& ids;
  const Enclosure& enclosure;
  double shift;
  Eigen::VectorXd source, reflectivity;    // of docs/solve.md, eq. (1): B = source + reflectivity H
  Eigen::VectorXd irradiation, radiosity;  // of rows, less the shift
};

// AnswerRows say of which rows of a HeatState the answers are.
struct AnswerRows {
  std::vector<std::string> names;
  std::vector<std::vector<uint32_t>> rows;      // of the state, by answer
  std::vector<std::vector<uint32_t>> surfaces;  // rows of the state, by surface
};
// Returns the rows of the state themselves, and their surfaces.
AnswerRows answerRows(const Ids& ids, const Enclosure& enclosure);

// Returns all answers but HeatSolution::steps.
//   In: closed: its pairs are not read; errors: of irradiations; answers: what to sum; bounds: of irradiations by row,
//     W/m2; may be empty
//   Throws: Error bad_input where a row would have to emit less than nothing.
HeatSolution answerHeat(const HeatState& state, const ClosedExchange& closed, const Outside& outside,
                        const CarriedErrors& errors, const AnswerRows& answers, const Eigen::VectorXd& bounds = {});

}  // namespace viewpeel
