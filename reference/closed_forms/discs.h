// coaxialDiscs() has the closed form of the form factor between two discs.
#pragma once

namespace viewpeel::reference {

// Returns F from a disc of radius a to a coaxial parallel disc of radius b at distance h, fronts facing:
//   F = (X - sqrt(X^2 - 4 s^2)) / 2 with s = b/a, X = 1 + s^2 + (h/a)^2,
// computed without cancellation as 2 s^2 / (X + sqrt((X - 2s)(X + 2s))), X - 2s = (1 - s)^2 + (h/a)^2.
//   In: radii a, b > 0, distance h > 0, in one unit.
//   Out: F from the disc of radius a to the disc of radius b, 1.
//   Error: 16 ulp relative, for all sizes and distances; tests/unit/discs_test.cpp.
//   Throws: Error bad_input (an argument that is not positive).
//   Cost: one square root.
//   Source: J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-41.
double coaxialDiscs(double radius_a, double radius_b, double distance);

}  // namespace viewpeel::reference
