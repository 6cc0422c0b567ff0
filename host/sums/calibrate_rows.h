// Guessed form factors that fit their rows: what the known row sums tell of pairs that few lines or none have met.
//
// A pair without lines gets the visibility of its neighbours. Such guesses err together where the faces around a face
// see more, or less, than the face itself, and the row then adds up to more or less than 1. Row sums are known: what is
// missing in a row, or is too much, moves the odds of all guesses of that row by one common factor. Entries that lines
// have measured stay as they are. Source: J.-C. Deville & C.-E. Särndal, Calibration estimators in survey sampling, J.
// Am. Stat. Assoc. 87, 1992, 376-382 (the logit
//   method, which keeps every visibility between 0 and 1).
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// The part of an entry that is a guess: weight * most * visibility.
struct Guess {
  uint32_t entry = 0;    // its index
  float most = 0;        // exchange area with nothing in between, input units squared
  float visibility = 0;  // guessed visibility
  float weight = 0;      // of the guess beside the pair's own lines: 1 without lines
};

// Moves guesses so that row sums come near to 1.
//   x_ij = x_ij + w_ij X_ij (t(s_ij, y_i + y_j) - s_ij),  t(s, y) = s e^y / (1 - s + s e^y)
//   with y such that row i gains g_i = f_i (A_i - sum_j x_ij), f_i = E_i^2 / (E_i^2 + V_i): E_i, the sum of the
//   standard errors of guesses in the row, is their error where all err alike; V_i, the sum of squared standard errors
//   of measured entries, is their share of what is missing. So rows whose guesses matter little keep their measured
//   sums.
//   In: entries of all pairs, environment and leak, sorted; guesses sorted by entry; areas: emitting area of each row
//   Out: entries, moved; reciprocity holds as before, for x_ij is one number. Standard errors stay.
//   Error: a row gains g_i to 1 % of the root of E_i^2 + V_i, or as near to it as visibilities from 0 to 1 allow.
//     tests/unit/calibrate_rows_test.cpp. The same for any number of threads.
//   Cost: some 20 passes over all guesses; memory 16 bytes a row.
void calibrateRows(std::vector<FormFactors::Entry>& entries, const std::vector<Guess>& guesses,
                   const std::vector<double>& areas);

// Row sums of entries and their standard errors, as of independent entries.
//   sum_j x_ij / A_i; an entry (i, i) counts once.
std::vector<Measured> sumRows(const std::vector<FormFactors::Entry>& entries, const std::vector<double>& areas);

}  // namespace viewpeel
