// solvePeeledGrey() solves grey enclosures without a matrix: docs/solve.md, eq. (1) to (6) and (14).
#pragma once
#include <viewpeel/solve.h>
#include "solve/peeled_exchange.h"
#include "solve/split_rows.h"

namespace viewpeel {

constexpr double kErrorResidual = 1e-3;  // relative residual of the equations for standard errors
constexpr uint64_t kVectorsOfGrey = 6;   // that are kept for each replicate

// Solves the equations for one round of directions.
//   All replicates' directions together make one symmetric operator, for which the enclosure is solved once. How far
//   each replicate's exchange differs from the exchange of all gives the errors of the answers, to first order.
//   Replicates are not solved each alone, for two reasons. The bias of a solution, which is of second order, would be 8
//   times as large. A small polygon that no line of a replicate meets would leave its equations without a solution.
//   In: exchange: after draw(); rows: kept by reference; residual: relative, where conjugate gradients end; guess: the
//     solution of a round before, empty before the first; it is replaced
//   Throws: Error limit where conjugate gradients do not converge; bad_input where a row would have to emit less than
//     nothing.
HeatSolution solvePeeledGrey(PeeledExchange& exchange, const SplitRows& rows, double residual, Columns& guess);

}  // namespace viewpeel
