// What one direction can contribute at most: the ranges that a-priori bounds on the error rest on.
#pragma once
#include <viewpeel/scene.h>

namespace viewpeel {

// A convex polygon, in the units of the lattice spacing h.
struct ConvexSize {
  double area = 0;
  double perimeter = 0;
  double diameter = 0;  // largest distance of two corners
};

// Of a polygon, in unit-ball units.
ConvexSize sizeOf(const Scene& scene, const Polygon& polygon);

// 2 x h^2 x (lattice points of a projection of x) is at most latticeRange(x, h), whatever the direction and the
// lattice's offset and rotation.
//   A convex region of area A and perimeter p holds at most A / h^2 + p / (2 h) + 1 points of a square lattice
//   (Nosarzewska 1948), and projection shrinks both.
//   Out: 2 A + p h + 2 h^2    Error: none.  Tests: tests/device/bounds_test.cpp.  Throws: nothing.  Cost: O(1).
//   Source: M. Nosarzewska, Evaluation de la difference entre l'aire d'une region plane convexe et le nombre des points
//     aux coordonnees entieres couverts par elle, Colloq. Math. 1, 1948.
double latticeRange(const ConvexSize& x, double h);

// The same for scanlines, 2 x h x (length of lattice rows in a projection of x).
//   The length w(y) of a convex region's chord at height y rises to its largest value and falls again, so that the sum
//   of h w over rows h apart exceeds the integral of w by at most h max w: for rows before and behind the highest one h
//   w(y_k) is at most the integral of w over the spacing between y_k and the next row towards it, and the highest one
//   itself adds at most h max w. The integral is the area of the projection, max w its diameter, and projection shrinks
//   both. Lengths are counted in columns of 2^-10 h: each of at most d / h + 1 rows may hold one column more than its
//   length.
//   Out: 2 A + 2 h d + 2^-9 h (d + h)    Error, Tests, Throws, Cost: as above.
double scanlineRange(const ConvexSize& x, double h);

// The range M of one direction's estimate of F_ij: both the points that i and j share and so the estimate are at most
// those of either.
//   In: range_i, range_j: latticeRange or scanlineRange of the two, area_i: A_i in the same units    Out: M =
//   min(range_i, range_j) / A_i
double formFactorRange(double range_i, double range_j, double area_i);

}  // namespace viewpeel
