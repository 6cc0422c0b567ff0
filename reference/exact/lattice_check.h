// checkLattice() checks the discretisation: it compares lattice counts with exact areas, direction by direction.
#pragma once
#include <functional>

#include <viewpeel/engine.h>
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel::reference {

// Take a lattice with uniformly random offset and rotation, and a region of perimeter P, large against the spacing h.
// The area that its lattice points measure, h^2 times their number, has the variance kLatticeVariance h^3 P. The
// constant is the sum over integer pairs (m, n) != 0 of (m^2 + n^2)^(-3/2), divided by 4 pi^3. The reason is that the
// mean of the region's squared Fourier transform at distance rho from 0 is P / (4 pi^3 rho^3) (Kendall & Moran 1963,
// chapter 5).
constexpr double kLatticeVariance = 0.0728370;

// This is the same constant for lattice rows, which measure h times their length in the region. Only the pairs (0, n)
// of the sum remain: 2 zeta(3) / (4 pi^3). It is a mean over rotations. Where no edge of the region runs along the
// rows, the variance is of order h^4. The few rotations with an edge nearly along the rows bring the h^3.
constexpr double kScanlineVariance = 0.0193841;

struct CheckOptions {
  std::vector<int> resolutions = {32, 64, 128};
  uint32_t directions = 6;  // independent directions
  uint32_t lattices = 64;   // random offsets and rotations per direction
  uint64_t seed = 1;
  bool blocked = false;                // test the regions of blocked pairs, too
  double counts_per_point = 1;         // h^2 over the area of one count
  double variance = kLatticeVariance;  // or kScanlineVariance
  // This is the probability that a correct discretisation fails the test of unbiasedness, over all regions and
  // resolutions together.
  double false_alarm_rate = 1e-4;
};

// Returns the counts of one random lattice, at a resolution.
using CountLattice = std::function<PairCounts(const Direction&, int resolution)>;

struct CheckRow {
  int resolution = 0;
  uint64_t regions_tested = 0;   // regions that were tested one by one; a region belongs to a pair and a direction
  uint64_t regions_pooled = 0;   // small or thin regions that were tested together
  double largest_deviation = 0;  // |mean counted area - exact area| in standard errors
  double allowed_deviation = 0;  // from the false-alarm rate
  std::string worst_pair;        // pair with the largest deviation
  double worst_difference = 0;   // its mean difference, unit-ball units squared
  double worst_standard_error = 0;
  uint64_t spread_regions = 0;  // regions that are wide enough for the asymptotic variance
  double spread_ratio = 1;      // measured over predicted variance, each summed over these regions
  // Areas of all pairs, environment and leak are added up here, and leak alone: means over lattices, summed over
  // directions, in unit-ball units squared.
  double total_counted = 0, total_exact = 0;
  double leak_counted = 0, leak_exact = 0;
  bool unbiased = true;
  bool spread_as_predicted = true;
};

struct CheckReport {
  std::vector<CheckRow> rows;
  double exact_seconds = 0, counting_seconds = 0;
  bool passes() const;
};

// Tests for every pair, direction and resolution whether the mean of the counted area over random lattices is the exact
// area, and whether its variance is the predicted one.
//   Method: Student's test per visible region with Bonferroni's correction. Regions with an expected count below 1/2 a
//     lattice or thinner than h / 2 (2 A / P) are pooled into one sum per resolution. The ratio of variances must lie
//     in [1/2, 2] over regions with A / P >= h, where terms of relative size h / width may still be felt.
//   Cost: directions exact projections, directions x lattices x resolutions counts.
CheckReport checkLattice(const Scene& scene, const Ids& ids, const CountLattice& count, const CheckOptions& options);

}  // namespace viewpeel::reference
