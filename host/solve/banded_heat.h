// solveBands() solves diffuse enclosures whose emissivities depend on the wavelength: docs/solve.md, eq. (12) and (13).
#pragma once
#include <viewpeel/solve.h>

namespace viewpeel {

// Solves each band of wavelengths by itself, and all bands together for the temperatures of rows with given heat
// fluxes.
//   In, Out, Throws: as solveHeat, for an enclosure with bands
//   Error: given heat fluxes are kept to 1e-12 of the largest emission. Standard errors: as solveHeat's. Tests:
//    tests/unit/solve_bands_test.cpp.
//   Cost: some ten products with the exchange areas X for each Newton step and band; bands with the same emissivities
//    share one matrix.
//    Standard errors take up to 128 further Newton steps.
HeatSolution solveBands(const FormFactors& form_factors, const Enclosure& enclosure);

}  // namespace viewpeel
