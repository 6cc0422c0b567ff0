// These bounds serve guarantees with unoccluded form factors: they hold for V - b (V + O - F0), b from a pilot.
//
// Derivation: docs/method.md, section 9, "With control variates". One direction's T = V + O of a pair lies in [0, M]
// with M the range of the smaller polygon (bounds.h). A line counts once at most, blocked or not. The second moment is
// bounded by eq. (31), and Bernstein's inequality, eq. (32), turns it into a bound on the mean. Without a visibility, b
// = 0, V^2 <= M V says the same. Where F0 = 0 nothing is seen. Hoeffding's bound (29) takes M, as without
// unoccluded form factors. So does the empirical Bernstein bound (30) of blocks, with the sample variance of X = V - b
// T. The choice among them is made beforehand: (32) where it is no more than (30) could be if the sample variance were
// 0. Environment and leak have T = all lines of their row, for which M F0 is of no use. They have (29) and (30), as 2 n
// bounds beside n (n - 1) / 2, and either kind gets half of delta. F0 is good to kUnoccludedRelativeError or
// kUnoccludedAbsoluteError, which is added to every bound.
#pragma once
#include <vector>

#include "sums/prior_sums.h"

namespace viewpeel {

// Returns Bernstein's bound for a bound v on the variance that holds before the run, with l = ln(2 / p).
//   bound = (M l / 3 + sqrt((M l / 3)^2 + 2 N v l)) / N
double givenVarianceBound(double variance, double range, double directions, double p);

class VisibilityBounds {
 public:
  // Takes the pairs of the prior and their bounds on the variance.
  //   In: ids by face; ranges as from formFactorRanges; prior: of all pairs, without visibilities where the range does
  //     not hold for T (keepBounded)
  //   Cost: 24 bytes a pair that can see each other.
  VisibilityBounds(const Ids& ids, const std::vector<double>& ranges, const Prior& prior);

  // Returns the least N after which everything is within epsilon but for probability delta, by Hoeffding's and
  // Bernstein's inequalities.
  //   Throws: Error bad_usage where N is above 1e15, or epsilon is below the error of unoccluded form factors.
  uint64_t directionsFor(double epsilon, double delta) const;

  // Variances holds sample variances of blocks: of pairs, and of environment, leak and self view, the largest by id.
  struct Variances {
    std::vector<double> of_pairs, of_rows;
  };
  Variances measureVariances(const ControlVariateSums& sums, double measure_area) const;

  // Returns the number of bounds of rows. They have half of any probability, so each kind gets its share by this
  // number.
  double rowBounds() const { return 2 * row_count_; }

  // Returns a bound that all errors stay below but for probability p, after this number of blocks.
  double largestBound(const Variances& variances, double blocks, double block_directions, double p) const;

 private:
  struct Pair {
    uint32_t i, j;
    double range, variance;
  };
  std::vector<double> areas_, ranges_, row_bounds_;  // of ids
  std::vector<Pair> pairs_;
  double pair_count_ = 0, row_count_ = 0;  // of bounds
  double largest_range_ = 0;
};

// Removes the visibilities whose lines could be counted more than once: of faces of several polygons, and all of them
// where there are several lattices.
Prior keepBounded(Prior prior, const Ids& ids, bool has_one_lattice);

}  // namespace viewpeel
