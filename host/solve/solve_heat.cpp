// solveHeat() solves the grey, diffuse enclosure: docs/solve.md.
#include <viewpeel/solve.h>

#include "solve/banded_heat.h"
#include "solve/check_enclosure.h"
#include "solve/directional_law.h"
#include "solve/heat_answers.h"
#include "solve/heat_bounds.h"
#include "solve/heat_errors.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

HeatSolution solveGrey(const FormFactors& form_factors, const Enclosure& enclosure) {
  const Ids& ids = form_factors.ids();
  const ClosedExchange closed = closeRows(form_factors);
  requireMaterials(closed, enclosure, ids);
  requireReferences(closed, enclosure, ids);
  HeatState state(ids, enclosure, closed.is_open);
  const Outside outside =
      makeOutside(closed, enclosure, [&](double temperature) { return emissivePower(temperature) - state.shift; });
  if (form_factors.hasIntervals() && !outside.up_errors.empty())
    throw Error(ErrorCode::bad_usage,
                "bounds of form factors do not tell sky from ground; leave out --epsilon, or give one "
                "temperature to 'environment'");
  const Irradiation irradiation(closed, state.reflectivity);
  state.take(irradiation.solve(closed.pairs * state.source + closed.environment.cwiseProduct(outside.power)));
  const HeatErrors errors(form_factors, closed, irradiation, state.radiosity, outside);
  VectorXd bounds;
  // Bounds on answers need an interval for every pair, so pairs without an entry must be known to be 0.
  if (form_factors.hasIntervals() && form_factors.unlistedBound() == 0)
    bounds = boundIrradiation(form_factors, closed, irradiation, state.radiosity);
  HeatSolution found = answerHeat(state, closed, outside, errors, answerRows(ids, enclosure), bounds);
  found.steps = irradiation.steps();
  return found;
}

}  // namespace

HeatSolution solveHeat(const FormFactors& form_factors, const Enclosure& enclosure) {
  requireDiffuse(enclosure);
  return enclosure.band_limits_um.empty() ? solveGrey(form_factors, enclosure) : solveBands(form_factors, enclosure);
}

}  // namespace viewpeel
