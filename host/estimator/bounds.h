// A range bounds what one direction can add to the estimate of a form factor. Guarantees derive the number of
// directions from ranges.
#pragma once
#include <viewpeel/scene.h>

namespace viewpeel {

// A ConvexSize has the measures of a convex polygon, in the unit of length of the lattice spacing h.
struct ConvexSize {
  double area = 0;
  double perimeter = 0;
  double diameter = 0;  // largest distance between two corners
};

// Measures a polygon of the scene, in unit-ball units.
ConvexSize sizeOf(const Scene& scene, const Polygon& polygon);

// Returns a bound on 2 h^2 times the number of lattice points in a projection of the polygon x. The bound holds for
// every direction, and for every offset and rotation of the lattice: docs/method.md, eq. (27).
//   Out: 2 A + p h + 2 h^2, with the area A and the perimeter p of x Error: none. Tests: tests/unit/bounds_test.cpp.
//   Throws: nothing. Cost: O(1).
//   Source: M. Nosarzewska, Evaluation de la difference entre l'aire d'une region plane convexe et le nombre des points
//     aux coordonnees entieres couverts par elle, Colloq. Math. 1, 1948.
double latticeRange(const ConvexSize& x, double h);

// Returns a bound for scanlines: on 2 h times the length of the lattice rows inside a projection of x, as latticeRange.
// docs/method.md, eq. (28), has the proof.
//   Out: 2 A + 2 h d + 2^-9 h (d + h), with the area A and the diameter d of x Error, Tests, Throws, Cost: as for
//   latticeRange.
double scanlineRange(const ConvexSize& x, double h);

// Returns the range M of one direction's estimate of F_ij. Polygons i and j share at most as many lattice points as the
// one with fewer has, so the smaller range bounds the estimate.
//   In: range_i, range_j: the latticeRange or scanlineRange of i and of j; area_i: A_i, in the unit of the ranges
//   Out: M = min(range_i, range_j) / A_i
double formFactorRange(double range_i, double range_j, double area_i);

}  // namespace viewpeel
