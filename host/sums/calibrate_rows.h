// calibrateRows moves guessed form factors so that they fit their rows: docs/method.md, eq. (40) and (41).
//
// A pair that no line met gets the visibility of its neighbours as a guess. Where the faces around a face see more, or
// less, than the face itself, the guesses of its row are all too large, or too small. The row then does not add up to
// 1. Calibration changes the odds of all guesses of a row by one factor, to make up for it. Entries measured by lines
// stay.
//   Source: J.-C. Deville & C.-E. Särndal, Calibration estimators in survey sampling, J. Am. Stat. Assoc. 87, 1992,
//     376-382 (the logit method, which keeps every visibility between 0 and 1).
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A Guess is the guessed part of an entry's exchange area, weight * most * visibility.
struct Guess {
  uint32_t entry = 0;    // index of the entry
  float most = 0;        // unoccluded exchange area, input units squared
  float visibility = 0;  // guessed visibility, 0 to 1
  float weight = 0;      // share of the guess in the entry's visibility, eq. (21): 1 where no line met the pair
};

// Moves guesses so that row sums come near to 1.
//   x_ij := x_ij + w_ij X_ij (t(s_ij, y_i + y_j) - s_ij),  t(s, y) = s e^y / (1 - s + s e^y)
//   with X_ij, s_ij, w_ij a guess's `most`, `visibility` and `weight`. Row i gains g_i of eq. (41), so rows whose
//   guesses matter little keep their measured sums.
//   In: entries: exchange areas of all pairs, environment and leak, sorted by (i, j); guesses: guessed parts of
//     entries, sorted by entry; areas: double[rows], emitting area of each row, input units squared
//   Out: entries: with moved values and the same standard errors. Reciprocity still holds, for x_ij is one number. The
//     same bits for any number of threads.
//   Error: a row gains g_i to within 1 % of the root of E_i^2 + V_i, or as near to it as visibilities from 0 to 1
//     allow; tests/unit/calibrate_rows_test.cpp.
//   Cost: some 20 passes over all guesses; memory 16 bytes a row.
void calibrateRows(std::vector<FormFactors::Entry>& entries, const std::vector<Guess>& guesses,
                   const std::vector<double>& areas);

}  // namespace viewpeel
