// These ranges bound the contribution of one direction; a-priori bounds on the error rest on them.
#pragma once
#include <viewpeel/scene.h>

namespace viewpeel {

// ConvexSize measures a convex polygon, in the units of the lattice spacing h.
struct ConvexSize {
  double area = 0;
  double perimeter = 0;
  double diameter = 0;  // largest distance of two corners
};

// Measures a polygon of the scene, in unit-ball units.
ConvexSize sizeOf(const Scene& scene, const Polygon& polygon);

// Returns a bound on 2 x h^2 x (lattice points of a projection of x), whatever the direction and the lattice's offset
// and rotation: docs/method.md, eq. (27).
//   Out: 2 A + p h + 2 h^2    Error: none.  Tests: tests/unit/bounds_test.cpp.  Throws: nothing.  Cost: O(1).
//   Source: M. Nosarzewska, Evaluation de la difference entre l'aire d'une region plane convexe et le nombre des points
//     aux coordonnees entieres couverts par elle, Colloq. Math. 1, 1948.
double latticeRange(const ConvexSize& x, double h);

// Returns the same bound for scanlines, on 2 x h x (length of lattice rows in a projection of x): docs/method.md, eq.
// (28), with its proof.
//   Out: 2 A + 2 h d + 2^-9 h (d + h)    Error, Tests, Throws, Cost: as latticeRange.
double scanlineRange(const ConvexSize& x, double h);

// Returns the range M of one direction's estimate of F_ij. The points that i and j share are at most as many as
// either has, and so is the estimate.
//   In: range_i, range_j: latticeRange or scanlineRange of the two, area_i: A_i in the same units
//   Out: M = min(range_i, range_j) / A_i
double formFactorRange(double range_i, double range_j, double area_i);

}  // namespace viewpeel
