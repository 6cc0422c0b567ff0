// Guessed form factors are moved so that they fit their rows: docs/method.md, eq. (40) and (41).
//
// A pair without lines gets the visibility of its neighbours. Such guesses err together where the faces around a face
// see more, or less, than the face itself. The row then adds up to more or less than 1. The missing or surplus part of
// a row moves the odds of all its guesses by one common factor. Entries that lines have measured stay as they are.
// Source: J.-C. Deville & C.-E. Särndal, Calibration estimators in survey sampling, J. Am. Stat. Assoc. 87, 1992,
// 376-382 (the logit method, which keeps every visibility between 0 and 1).
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A Guess is the guessed part of an entry: weight * most * visibility.
struct Guess {
  uint32_t entry = 0;    // its index
  float most = 0;        // exchange area with nothing in between, input units squared
  float visibility = 0;  // guessed visibility
  float weight = 0;      // of the guess beside the pair's own lines: 1 without lines
};

// Moves guesses so that row sums come near to 1.
//   x_ij = x_ij + w_ij X_ij (t(s_ij, y_i + y_j) - s_ij),  t(s, y) = s e^y / (1 - s + s e^y)
//   Row i gains g_i of eq. (41), so rows whose guesses matter little keep their measured sums.
//   In: entries of all pairs, environment and leak, sorted; guesses sorted by entry; areas: emitting area of each row
//   Out: entries, moved; reciprocity holds as before, for x_ij is one number. Standard errors stay.
//   Error: a row gains g_i to 1 % of the root of E_i^2 + V_i, or as near to it as visibilities from 0 to 1 allow.
//     tests/unit/calibrate_rows_test.cpp. The same for any number of threads.
//   Cost: some 20 passes over all guesses; memory 16 bytes a row.
void calibrateRows(std::vector<FormFactors::Entry>& entries, const std::vector<Guess>& guesses,
                   const std::vector<double>& areas);

// Returns row sums of entries, sum_j x_ij / A_i with (i, i) once, and their standard errors, as of independent entries.
std::vector<Measured> sumRows(const std::vector<FormFactors::Entry>& entries, const std::vector<double>& areas);

}  // namespace viewpeel
