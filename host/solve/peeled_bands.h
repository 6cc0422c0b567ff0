// solvePeeledBands() solves enclosures with bands of wavelengths without a matrix: docs/solve.md, eq. (12) and (15).
#pragma once
#include <viewpeel/solve.h>
#include "solve/peeled_exchange.h"
#include "solve/split_rows.h"

namespace viewpeel {

constexpr uint64_t kVectorsOfBands = 10;  // that are kept for each replicate and band

// Solves the equations of all bands together for one round of directions. Each product with the exchange has a column
// for each band, so that one sweep serves all bands.
//   In, Out, Throws: as solvePeeledGrey, for an enclosure with bands whose rows are not split. The guess has a column
//     for each band. Error limit where Newton's method does not converge.
//   Cost: a few dozens of products with a column for each band, and half as many with a column for each replicate and
//     band.
HeatSolution solvePeeledBands(PeeledExchange& exchange, const SplitRows& rows, double residual, Columns& guess);

}  // namespace viewpeel
