// parallelRectangles() and perpendicularRectangles() have the closed forms of form factors between axis-parallel
// rectangles.
#pragma once

namespace viewpeel::reference {

struct Interval {
  double low = 0, high = 0;
};

// Returns F from the rectangle x by y in the plane z = 0 to the rectangle xi by eta in the plane z = distance, fronts
// facing:
//   F = 1/A sum_ijkl (-1)^(i+j+k+l) G(x_i - xi_k, y_j - eta_l),
//   2 pi G(p, q) = q sqrt(p^2 + z^2) atan(q / sqrt(p^2 + z^2)) + p sqrt(q^2 + z^2) atan(p / sqrt(q^2 + z^2))
//                  - z^2/2 ln(p^2 + q^2 + z^2).
//   In: intervals with low < high, distance > 0; one unit of length for all.
//   Out: F from the first to the second, 1.
//   Error: rounding of 16 cancelling terms in long double: at most 64 e R^2 / A, e = 2^-63, R the distance between the
//          farthest corners, A = the first rectangle's area; so 1e-10 absolute while R^2 / A < 1e7, and 1e-10 relative
//          for two equal squares while distance / side < 45. tests/unit/rectangles_test.cpp.
//   Throws: Error bad_input (an empty interval, a distance that is not positive).
//   Cost: 16 terms.
//   Source: J. R. Ehlert & T. F. Smith, View factors for perpendicular and parallel rectangular plates, J.
//     Thermophysics and Heat Transfer 7(1), 1993, 173-174; J. R. Howell, A Catalog of Radiation Heat Transfer
//     Configuration Factors, C-13.
double parallelRectangles(Interval x, Interval y, Interval xi, Interval eta, double distance);

// Returns F from the rectangle x by y in the plane z = 0 to the rectangle y = eta, z = zeta in the plane x = 0, fronts
// towards +z and +x:
//   F = 1/A sum_ijkl (-1)^(i+j+k+l) G(x_i^2 + zeta_k^2, y_j - eta_l),
//   2 pi G(c2, q) = q sqrt(c2) atan(q / sqrt(c2)) - (c2 - q^2)/4 ln(c2 + q^2).
//   In: intervals with low < high, x.low >= 0, zeta.low >= 0 (both 0: the planes' common line is a common edge).
//   Out: F from the first to the second, 1.
//   Error: as for parallelRectangles.
//   Throws: Error bad_input (an empty interval, a negative x or zeta).
//   Cost: 16 terms.
//   Source: Ehlert & Smith as above; Howell's catalogue, C-16 (C-14 with a common edge).
double perpendicularRectangles(Interval x, Interval y, Interval eta, Interval zeta);

}  // namespace viewpeel::reference
