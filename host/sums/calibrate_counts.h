// calibrateCounts() moves counted form factors so that they fit their rows: docs/method.md, mixtures.
//
// Along common directions most pairs of many polygons are met once or never, so that the error of such a form factor is
// as large as the form factor. A row adds up to 1, so its counted form factors should add up to what its other entries
// leave, which is known far better than their own sum. Calibration multiplies each of them by a factor of its two rows
// (J.-C. Deville & C.-E. Särndal, Calibration estimators in survey sampling, J. Am. Stat. Assoc. 87, 1992, 376-382;
// multiplicative method). Where rays count, entries move by their variances: eq. (62).
#pragma once
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"

namespace viewpeel {

//   In: all: form factors between polygons, with environment and leak, whose rows add up to 1; with_lines: pairs whose
//     entries stay, sorted; most: of a counted form factor, from the row with the smaller area; counted_rows: sums of
//     counted entries by row, with standard errors that all.rowSums() include; of_rays: double[rows], the exchange area
//     for which one ray of a row stands, input units squared; empty where common directions count
//   Out: Counted values x_ij become min(x_ij (1 + t / 8)^8, most min(A_i, A_j)) with t = p_ij y_i + p_ji y_j, and keep
//     their standard errors. Along common directions p is 1; of rays it follows from the entry's variance. Row i gains
//     V_c / V of what it lacks, V being the variance of its sum, and V_c the part of its counts. Row sums keep the
//     standard errors that they had before. The same bits for any number of threads.
//   Error: a row gains this to within a tenth of its standard error, or as near to it as |y| up to 1 allows;
//     tests/unit/line_mixture_test.cpp.
//   Cost: at most 20 passes over the entries; memory 48 bytes a row, and a bit an entry.
FormFactors calibrateCounts(FormFactors all, const std::vector<LinePair>& with_lines, double most,
                            const std::vector<Measured>& counted_rows, const std::vector<double>& of_rays);

}  // namespace viewpeel
