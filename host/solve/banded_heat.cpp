#include "solve/banded_heat.h"

#include "solve/band_answers.h"
#include "solve/band_system.h"
#include "solve/carry_pair_errors.h"
#include "solve/check_enclosure.h"
#include <viewpeel/error.h>

namespace viewpeel {

HeatSolution solveBands(const FormFactors& form_factors, const Enclosure& enclosure) {
  if (form_factors.hasIntervals())
    throw Error(ErrorCode::bad_usage, "there are no bounds with bands of wavelengths; leave out --epsilon");
  const ClosedExchange closed = closeRows(form_factors);
  requireMaterials(closed, enclosure, form_factors.ids());
  requireReferences(closed, enclosure, form_factors.ids());
  BandSystem system(closed, enclosure);
  system.solve(form_factors.ids().names);
  const BandErrors errors = carryPairErrors(form_factors, closed, system);
  HeatSolution found = answerBands(form_factors.ids(), system.state(), closed, errors);
  found.steps = system.steps();
  return found;
}

}  // namespace viewpeel
