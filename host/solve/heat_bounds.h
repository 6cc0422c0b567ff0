// boundIrradiation() turns intervals of form factors into bounds on irradiations: docs/solve.md, eq. (10).
#pragma once
#include "solve/irradiation.h"

namespace viewpeel {

// Returns bounds w on irradiations, W/m2: |H~_k - H_k| <= w_k for each row k. Here H is the solution, and H~ the
// solution for any form factors within their intervals whose rows sum to 1.
//   Method: X are the measured exchange areas, X~ the others, A the areas, R the reflectivities, B the radiosities.
//    v = |X~ - X| |B| bounds the change of the right side. (A - X~ R)^-1 has no entry below 0, so any w with
//    (A - X~ R) w >= v for all X~ is a bound. Iteration finds such a w, which is then checked.
//   In: measured: with intervals; closed: made of them; irradiation: with the solution's reflectivities; radiosity: by
//    row, less the environment's emissive power if the scene is open
//   Out: w, by row; infinite where intervals are too wide to find one
//   Error: rounding. Tests: tests/unit/solve_bounds_test.cpp.
//   Cost: a few times Irradiation::solve.
Eigen::VectorXd boundIrradiation(const FormFactors& measured, const ClosedExchange& closed,
                                 const Irradiation& irradiation, const Eigen::VectorXd& radiosity);

}  // namespace viewpeel
