// Intervals of form factors bound irradiations: docs/solve.md, eq. (10).
#pragma once
#include "solve/irradiation.h"

namespace viewpeel {

// Returns bounds w with |H~_k - H_k| <= w_k for the solution H~ of any form factors within their intervals whose rows
// sum to 1.
//   v = |X~ - X| |B| bounds what the difference of exchange areas does to the right side. (A - X~ R)^-1 has no entry
//   below 0. So any w with (A - X~ R) w >= v for all X~ is a bound; one is found by iteration, and checked.
//   In: measured: with intervals; closed: of these; irradiation: of the solution's reflectivities; radiosity: of rows,
//     less the environment's where there is one
//   Out: w, n; infinite where intervals are so wide that no w was found
//   Error: rounding. Tests: tests/unit/solve_bounds_test.cpp.
//   Cost: as Irradiation::solve, a few times.
Eigen::VectorXd boundIrradiation(const FormFactors& measured, const ClosedExchange& closed,
                                 const Irradiation& irradiation, const Eigen::VectorXd& radiosity);

}  // namespace viewpeel
