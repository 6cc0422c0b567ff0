// answerBands() goes from irradiations in bands of wavelengths to what users ask for: temperatures, heat fluxes and
// sums over surfaces, with their errors.
#pragma once
#include "solve/band_errors.h"
#include "solve/band_state.h"

namespace viewpeel {

// Returns all answers but HeatSolution::steps.
//   In: ids: rows of the state; closed: its pairs are not read; errors: of the state
HeatSolution answerBands(const Ids& ids, const BandState& state, const ClosedExchange& closed,
                         const BandErrors& errors);

}  // namespace viewpeel
