// How much of the variance of form factors comes from directions, and how much from the lattice.
//
// A pilot counts every direction on two lattices: what the two have in common varies with the directions, the rest from
// lattice to lattice. With unoccluded form factors, what varies is left when visibilities are taken off: each half of
// the pilot takes those that the other half tells.
#pragma once
#include <cstdint>
#include <vector>

#include "estimator/estimate.h"
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// A replicate of a pilot, on either lattice.
struct PilotCounts {
  PairCounts first, second;
};

// Of one replicate, the largest of all form factors, each of another where need be; relative to the form factor where
// the goal is.
struct PilotVariances {
  double of_directions = 0, of_lattices = 0;
  double doubt = 0;  // standard error of of_directions: few replicates tell little of a covariance beside lattices that
                     // vary much more
};

//   In: counted: replicates, an even number of at least 4; id_of_face: with unoccluded form factors, empty without;
//   measure_area: of a count, as in ReplicateSums; options: the goal
//   Cost: O(nonzeros log nonzeros) a replicate.
PilotVariances pilotVariances(const std::vector<PilotCounts>& counted, const Ids& ids,
                              const std::vector<uint32_t>& id_of_face, double measure_area,
                              const EstimateOptions& options);

}  // namespace viewpeel
