// lineFormFactors makes form factors from the pair lines and the common directions of a run.
#pragma once
#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"
#include "sums/replicate_sums.h"

namespace viewpeel {

// A counted form factor is cut to this multiple of the least form factor with lines. A count stands for its pair, and
// for similar pairs that no line met. With a smaller multiple row sums would be too small.
constexpr double kMostOfCounted = 3;

// No unoccluded form factor from the smaller face exceeds this one. Where pairs below it have no lines, all pairs are
// counted.
constexpr double kAllCounted = 1;

// A row of an open scene that lacks more than this number of standard errors surely sees the environment.
constexpr double kBeyondDoubt = 3;

// Returns the form factors between all rows, and from each row to environment and leak.
//   In: lines: pair lines of pairs of faces; by: whether rows of the result are faces or surfaces; counted: counts
//     along common directions, by these rows; measure_area, count_area: as in ReplicateSums
//   Out: Where all pairs have lines, entries between rows come from lines. So does leak, or from common directions
//     where no pair lines found it; there LeakingFaces::rays limit it. The environment of a row is 1 less its pairs and
//     its leak. A row has an environment if a common direction saw one of its lines leave the scene. It also has one if
//     it lacks more than three standard errors and any line left the scene. Other rows have none, and need not add up
//     to 1.
//     Where pairs below a least form factor have no lines, common directions have counted these pairs, environment and
//     leak.
//   Error: the variance of an environment is the sum of the variances of the row's pairs and of its leak, or comes from
//     its counts. A counted form factor errs by at most kMostOfCounted times the least form factor, from the smaller
//     face.
FormFactors lineFormFactors(const LineSums& lines, By by, const ReplicateSums& counted, double measure_area,
                            double count_area);

// Returns by row the largest margin of its entries: what an entry's few lines may have missed, where all of them agree.
// Over many pairs it is nothing on average, but one pair of a row may err by it.    Out: double[row_count]
std::vector<double> largestMargins(const std::vector<FormFactors::Entry>& entries, size_t row_count);

// Returns, by surface, whether one of its faces leaks.
//   In: of_face: LeakingFaces::of_face; surface: uint32_t[faces], the surface of each face
std::vector<bool> leakingSurfaces(const std::vector<bool>& of_face, const std::vector<uint32_t>& surface,
                                  size_t surfaces);

// Returns form factors in the same way from given exchange areas of pairs of faces, and of faces with kLeak.
//   In: entries: sorted, with independent errors, input units squared; surface: uint32_t[faces], the surface of each
//     face; leaking: of rows of the result
FormFactors lineFormFactors(std::vector<FormFactors::Entry> entries, const std::vector<uint32_t>& surface, By by,
                            const ReplicateSums& counted, double measure_area, const LeakingFaces& leaking = {});

}  // namespace viewpeel
