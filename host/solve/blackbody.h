// These functions give the emission of a black surface in a band of wavelengths.
#pragma once

namespace viewpeel {

// A Band of wavelengths reaches from `low` to `high`, in micrometres; `high` may be infinite.
struct Band {
  double low_um = 0, high_um = 0;
};

// Returns the share of black emission below a wavelength, F = (15 / pi^4) times the integral of x^3 / (e^x - 1) from
// z = C_2 / (wavelength temperature) to infinity.
//   In: um_K: wavelength times temperature, micrometres kelvin, from 0 to infinity
//   Out: 0 to 1    Error: 1e-14. Tests: tests/unit/blackbody_test.cpp.    Cost: some 20 terms.
//   Source: S. L. Chang & K. T. Rhee, Blackbody radiation functions, Int. Comm. Heat Mass Transfer 11, 1984, 451-455.
//    Below z = 2 their series converges slowly, and the power series with Bernoulli's numbers is used.
double blackbodyShare(double um_K);

// Returns the emission of a black surface in the band, W/m2.    In: temperature: K
double bandPower(const Band& band, double temperature);
// Returns the derivative of this emission with respect to the temperature, W/m2 per kelvin.
double bandPowerSlope(const Band& band, double temperature);

}  // namespace viewpeel
