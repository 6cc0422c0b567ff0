// Guarantees with unoccluded form factors: bounds on V - b (V + O - F0), b from a pilot.
//
// One direction's V of a pair of polygons and T = V + O, in F's units of the smaller one, have 0 <= V <= T <= M
// (bounds.h: a line is counted once at most, blocked or not), and E[T] = F0. So X = V - b T has b between 0 and 1 and
// lies in [-b T, (1 - b) T]: an interval as wide as V's own, M, whatever b is - a range is no smaller with closed
// forms, unless something proves that nothing is in between. What is smaller is the variance, and a bound on it is
// known beforehand:
//   E[X^2] <= max(b, 1 - b)^2 E[T^2] <= max(b, 1 - b)^2 M F0,
// for X^2 is at most (b T)^2 or ((1 - b) T)^2, and T^2 <= M T. Without a visibility, b = 0, V^2 <= M V says the same.
// Where F0 = 0 nothing is seen.
//   Bernstein (S. Boucheron, G. Lugosi, P. Massart, Concentration inequalities, 2013, theorem 2.10 and corollary 2.11):
//   N independent directions, in strata of equal size or not, have
//     a mean that is off by t or more with probability at most 2 exp(-N t^2 / (2 v + 2 M t / 3)), v a bound on the mean
//     of E[X^2] over strata, which is that of one direction.
//   Hoeffding's bound is that of M, as without unoccluded form factors, and so is the empirical Bernstein bound of
//   blocks, with the sample variance of X. A bound is chosen by what is known
//     beforehand: Bernstein's where it is no more than the empirical one could be if the variance were 0.
//   Environment and leak have T = all lines of the row, M F0 no use: Hoeffding's and the empirical bound of X. They are
//   2 n bounds beside n (n - 1) / 2: either kind gets half of delta. F0 is good to kUnoccludedRelativeError or
//   kUnoccludedAbsoluteError, which adds so much to every bound.
#pragma once
#include <vector>

#include "sums/prior_sums.h"

namespace viewpeel {

// (M l / 3 + sqrt((M l / 3)^2 + 2 N v l)) / N, l = ln(2 / p): Bernstein's inequality with a variance known beforehand.
double givenVarianceBound(double variance, double range, double directions, double p);

class VisibilityBounds {
 public:
  //   In: ids by face; ranges as from formFactorRanges; prior: of all pairs, without visibilities where the range does
  //   not hold for T (keepBounded)
  //   Cost: 24 bytes a pair that can see each other.
  VisibilityBounds(const Ids& ids, const std::vector<double>& ranges, const Prior& prior);

  // The least N after which everything is within epsilon but for probability delta, by Hoeffding's and Bernstein's
  // inequalities.
  //   Throws: Error bad_usage where that is above 1e15, or epsilon is below what unoccluded form factors are good to.
  uint64_t directionsFor(double epsilon, double delta) const;

  // Sample variances of blocks: of pairs, and of environment, leak and self view, the largest by id.
  struct Variances {
    std::vector<double> of_pairs, of_rows;
  };
  Variances measureVariances(const ControlVariateSums& sums, double measure_area) const;

  // The bounds of rows, which have half of any probability: as many as all would be.
  double rowBounds() const { return 2 * row_count_; }

  // What all errors are below but for probability p, after so many blocks.
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

// Without the visibilities whose lines could be counted more than once: faces of several polygons, and rows where there
// are several lattices.
Prior keepBounded(Prior prior, const Ids& ids, bool has_one_lattice);

}  // namespace viewpeel
