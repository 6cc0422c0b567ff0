// VisibilityBounds bounds the errors of guarantees with unoccluded form factors. Their estimates are the means of
// V - b (V + O - F0) over directions. V and O are a direction's facing and blocked lines as form factors, F0 is the
// unoccluded form factor, and b the visibility that a pilot has fixed.
//
// Derivation: docs/method.md, section 9, "With control variates". One direction's T = V + O of a pair lies in [0, M],
// because a line counts once at most, blocked or not. M is the range of the smaller polygon (bounds.h). Eq. (31) bounds
// the second moment of V - b T. Bernstein's inequality, eq. (32), then bounds the error of the mean. Without a
// visibility b is 0, and V^2 <= M V bounds the second moment. Where F0 = 0 the two see nothing of each other.
// Hoeffding's bound (29) takes M, as without unoccluded form factors. The empirical Bernstein bound (30) of blocks
// takes the sample variance of X = V - b T. Each pair has (32) where it is no more than (30) could be with a sample
// variance of 0, else (29) and (30). This choice is made before the run. For environment and leak T is all lines of the
// row, and eq. (31) does not help. So each row has (29) and (30) twice, 2 n bounds beside the n (n - 1) / 2 of pairs.
// Rows and pairs get half of delta each. Every bound includes the error of F0, kUnoccludedRelativeError or
// kUnoccludedAbsoluteError.
#pragma once
#include <vector>

#include "sums/prior_sums.h"

namespace viewpeel {

// Returns Bernstein's bound on the error of a mean of N directions, from a bound v on the variance that is known before
// the run. It fails with probability at most p; l = ln(2 / p).
//   bound = (M l / 3 + sqrt((M l / 3)^2 + 2 N v l)) / N
double givenVarianceBound(double variance, double range, double directions, double p);

class VisibilityBounds {
 public:
  // Computes the bound on the variance of every pair of the prior.
  //   In: ids: by face; ranges: as formFactorRanges() returns them; prior: of all pairs. Where the range does not bound
  //     T, the prior has no visibility (keepBounded).
  //   Cost: 24 bytes for each pair with F0 > 0.
  VisibilityBounds(const Ids& ids, const std::vector<double>& ranges, const Prior& prior);

  // Returns the least number of directions after which all errors are at most epsilon with probability 1 - delta, by
  // Hoeffding's and Bernstein's inequalities.
  //   Throws: Error bad_usage where N is above 1e15, or epsilon is below the error of unoccluded form factors.
  uint64_t directionsFor(double epsilon, double delta) const;

  // Variances holds sample variances of blocks. of_rows is the largest of environment, leak and the id with itself.
  struct Variances {
    std::vector<double> of_pairs, of_rows;
  };
  Variances measureVariances(const ControlVariateSums& sums, double measure_area) const;

  // Returns twice the number of bounds of rows. Rows share half of a failure probability p, so each bound of a row has
  // p divided by this.
  double rowBounds() const { return 2 * row_count_; }

  // Returns a bound that all errors stay below with probability 1 - p, after this number of blocks.
  double largestBound(const Variances& variances, double blocks, double block_directions, double p) const;

 private:
  struct Pair {
    uint32_t i, j;
    double range, variance;
  };
  std::vector<double> areas_, ranges_, row_bounds_;  // of ids
  std::vector<Pair> pairs_;
  double pair_count_ = 0, row_count_ = 0;  // number of pairs and of rows with bounds
  double largest_range_ = 0;
};

// Removes the visibilities of environment and leak where there are several lattices, and the visibilities of pairs with
// a face of several polygons. Lines of such pairs could count more than once.
Prior keepBounded(Prior prior, const Ids& ids, bool has_one_lattice);

}  // namespace viewpeel
