// A pilot splits the variance of form factors into the part of directions and the part of the lattice.
//
// It counts every direction on two lattices. The common part of both varies with the directions, the rest from lattice
// to lattice. With unoccluded form factors only the part that is left without visibilities varies: each half of the
// pilot takes the visibilities of the other half.
#pragma once
#include <cstdint>
#include <vector>

#include "estimator/estimate.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// PilotCounts is a replicate of a pilot, on either lattice.
struct PilotCounts {
  PairCounts first, second;
};

// PilotVariances are variances of one replicate. Each is the largest of all form factors, perhaps of different ones,
// and relative where the goal is.
struct PilotVariances {
  double of_directions = 0, of_lattices = 0;
  // This is the standard error of of_directions. A covariance of few replicates is uncertain beside lattices that vary
  // much more.
  double doubt = 0;
};

// Computes both variances from the counts of a pilot.
//   In: counted: replicates, an even number of at least 4; id_of_face: with unoccluded form factors, empty without;
//     measure_area: of a count, as in ReplicateSums; options: the goal
//   Cost: O(nonzeros log nonzeros) a replicate.
PilotVariances pilotVariances(const std::vector<PilotCounts>& counted, const Ids& ids,
                              const std::vector<uint32_t>& id_of_face, double measure_area,
                              const EstimateOptions& options);

}  // namespace viewpeel
