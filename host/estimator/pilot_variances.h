// A pilot splits the variance of form factors into the part of directions and the part of the lattice.
//
// The pilot counts every direction on two lattices. The covariance of the two counts is the variance due to directions.
// The rest of their variance is due to the lattice. With unoccluded form factors the pilot measures what is left after
// the control variates. Each half of the pilot then takes its visibilities from the other half.
#pragma once
#include <cstdint>
#include <vector>

#include "estimator/estimate.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// PilotCounts holds the counts of one replicate of a pilot, on its first and on its second lattice.
struct PilotCounts {
  PairCounts first, second;
};

// PilotVariances holds the two variances of one replicate. Each is the largest over all form factors. The two may come
// from different form factors. They are relative to the form factor where the goal is relative. Where the goal is a
// root mean square, they are means over all n^2 form factors between rows.
struct PilotVariances {
  double of_directions = 0, of_lattices = 0;
  bool are_means = false;
  // by_meetings[m] is the largest variance, or the sum of variances, of both parts, over the pairs that m of the
  // pilot's replicates met.
  std::vector<double> by_meetings;
  // This is the standard error of of_directions. It is large where the lattice varies much more than the directions,
  // because few replicates measure a small covariance badly.
  double doubt = 0;
};

// Computes both variances from the counts of a pilot.
//   In: counted: the replicates, an even number of at least 4; id_of_face: uint32_t[face] with unoccluded form factors,
//     else empty; measure_area: the area of one count, as in ReplicateSums; options: the goal
//   Cost: O(nonzeros log nonzeros) a replicate.
PilotVariances pilotVariances(const std::vector<PilotCounts>& counted, const Ids& ids,
                              const std::vector<uint32_t>& id_of_face, double measure_area,
                              const EstimateOptions& options);

// Returns the share of a form factor's variance that is left if each replicate has `more` times as many directions, for
// every sampler but iid: docs/method.md, section 8.
//   In: meetings: directions of a replicate that meet the pair, in the mean
double varianceLeft(double meetings, double more);

// Returns the same for the largest variance over all form factors, or for the mean of all.
double varianceLeft(const PilotVariances& variances, double more);

}  // namespace viewpeel
