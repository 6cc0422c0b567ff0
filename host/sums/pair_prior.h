// A PairPrior is what the run knows about a pair of faces beforehand: its unoccluded exchange area, and its visibility
// in pilots.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sums/control_variate_sums.h"

namespace viewpeel {

// The pair is face i with face j, or with environment or leak.
struct PairPrior {
  uint32_t i, j;  // i < j
  // This is the visibility of the pair in control variates of faces, and the pair's visibility where no line met it.
  // Its unit is 2^-kVisibilityBits.
  uint32_t visibility = 0;
  // This is the visibility of the pair in control variates between surfaces: the same, or 0.
  uint32_t surface_visibility = 0;
  // This is the unoccluded exchange area, or A_i for environment and leak, in input units squared. Where it is unknown
  // it is infinite, and both visibilities are 0.
  double exchange = 0;

  bool operator==(const PairPrior&) const = default;
};

// Returns whether the form factor of a pair that no pilot met is estimated as visibility times unoccluded form factor.
// It is where nearly every run meets the pair, docs/method.md, eq. (42). Otherwise its counts alone are the estimate:
// the visibility would leave its row too low on average, because runs that miss the pair have no entry for it.
//   In: directions: number of directions in all replicates; count_area: as in ReplicateSums; exchange: unoccluded
//     exchange area; area: the smaller area of the two faces; all three in input units squared
inline bool isEstimatedByVisibility(double directions, double count_area, double exchange, double area) {
  constexpr double kLeastLines = 64, kLeastDirections = 16;
  const double lines = directions * exchange / (2 * count_area);
  return lines >= kLeastLines && lines / (1 + 8 / 27.0 * area / count_area) >= kLeastDirections;
}

// A BoundedExchange is an unoccluded exchange area with a bound on its error, both in input units squared.
struct BoundedExchange {
  double area = 0, error = 0;
};

// Returns the known part b A_i F0_ij of a pair's exchange area.
//   In: visibility: b, in units of 2^-kVisibilityBits; areas: area of each face, input units squared; lines: as in
//     lineOf
inline PriorExchange exchangeOf(const PairPrior& pair, uint32_t visibility, const std::vector<double>& areas,
                                const std::vector<uint64_t>& lines) {
  // By rounding, an unoccluded exchange area may exceed the area of a face, which bounds it.
  const double most = std::min({pair.exchange, areas[pair.i], pair.j < kEnvironment ? areas[pair.j] : INFINITY});
  return {pair.i, pair.j, most * visibility / kVisibilityOne, std::isinf(pair.exchange) ? INFINITY : most,
          lineOf(lines, pair.i, pair.j)};
}

}  // namespace viewpeel
