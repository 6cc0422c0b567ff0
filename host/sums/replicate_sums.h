// ReplicateSums adds up the counts of pairs over replicates and makes form factors of the sums.
#pragma once
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/ids.h>
#include "sums/pair_blocks.h"
#include "sums/pair_count.h"

namespace viewpeel {

// FurtherReplicates are replicates in which only some rows had rays (ReplicateSums::addOutside).
struct FurtherReplicates {
  uint64_t replicates = 0;        // their number
  std::vector<uint64_t> of_rows;  // by row, how many of them it had rays in; empty where there are none
};

// A ReplicateSums holds exact sums, in 128-bit integers.
class ReplicateSums {
 public:
  __extension__ using Wide = unsigned __int128;
  // A Sum adds up, over replicates, the count of each replicate, and its square.
  struct Sum {
    Wide sum = 0, sum_of_squares = 0;
    void add(uint64_t count) {
      sum += count;
      sum_of_squares += Wide(count) * count;
    }
    void add(const Sum& other) {
      sum += other.sum;
      sum_of_squares += other.sum_of_squares;
    }
  };
  struct PairSum {
    uint32_t i, j;
    Sum sum{};
  };

  explicit ReplicateSums(Ids ids) : ids_(std::move(ids)), pairs_(ids_.count()), row_sums_(ids_.count()) {}
  // Restores sums from a checkpoint.    In: pairs: sorted by (i, j), every pair at most once; row_sums: Sum[ids]
  ReplicateSums(Ids ids, uint64_t replicate_count, const std::vector<PairSum>& pairs, std::vector<Sum> row_sums,
                FurtherReplicates further = {})
      : ids_(std::move(ids)),
        pairs_(ids_.count(), pairs),
        row_sums_(std::move(row_sums)),
        replicate_count_(replicate_count),
        further_(std::move(further)) {}

  // Says that counts are of rays (ray_engine.h).
  //   In: areas: double[ids], A N / n, with the area A of a row's largest polygon, its n rays in a replicate and the N
  //     directions of a replicate; input units squared
  void countRays(std::vector<double> areas) { ray_areas_ = std::move(areas); }
  // Says what one line adds.    In: counts: double[ids], of a line that meets a polygon of the row, on average
  void setLineSteps(std::vector<double> counts) { line_steps_ = std::move(counts); }
  bool countsRays() const { return !ray_areas_.empty(); }
  // Adds one replicate.    Cost: O(pairs), on all threads.
  void add(const PairCounts& counts);
  // Adds a replicate in which only some rows had rays, for their environment and leak.
  //   In: counts: of environment and leak; rows: bool[ids]
  void addOutside(const PairCounts& counts, const std::vector<bool>& rows);
  // Adds one replicate to the row sums alone, for runs whose pairs are summed elsewhere.
  void addRows(const PairCounts& counts);
  // Adds sums of other replicates.    In: others: sums of the same ids    Cost: O(pairs).
  void add(const ReplicateSums& others);

  const Ids& ids() const { return ids_; }
  const PairBlocks<PairSum>& pairs() const { return pairs_; }
  const std::vector<Sum>& rowSums() const { return row_sums_; }
  uint64_t replicateCount() const { return replicate_count_; }
  const FurtherReplicates& further() const { return further_; }
  // Returns the number of replicates in which a pair could be counted.
  uint64_t replicatesOf(uint32_t i, uint32_t j) const;

  // Returns the form factors of all pairs with a facing line: A_i F_ij = 2 measure_area x (mean count of a replicate),
  // or twice as much for i = j.
  //   In: measure_area: the C_ij of eq. (2) for which a mean count of 1 stands, unitArea() scale^2 / directions of a
  //     replicate; count_area: the area in the plane orthogonal to its direction for which one count stands,
  //     unitArea() scale^2; infinite where it is unknown. Both are in input units squared.
  //   Error: values have rounding alone; standard errors: docs/method.md, eq. (12); tests/unit/form_factors_test.cpp.
  FormFactors formFactors(double measure_area, double count_area = INFINITY) const;
  // Returns the row sums of the same form factors, with their own spread over replicates.
  std::vector<Measured> measureRows(double measure_area) const;
  // Returns the exchange area for which one ray of each row stands, in the mean of all replicates: double[ids], input
  // units squared; empty without rays.    In: as in formFactors
  std::vector<double> exchangesOfRays(double measure_area, double count_area) const;
  // Returns how much the environments of rows with rays vary, over all rows: the sum of the variances of their form
  // factors over the sum of those that independent rays would have. Returns 0 without rays.    In: as in formFactors
  double rayEfficiency(double measure_area, double count_area) const;
  // Returns the bound that unmetBound() returns, of pairs that no ray met.    In: directions: of all replicates
  double unmetBoundOfRays(double directions) const;
  // Returns the variance of a row's exchange area with the environment, if its rays were independent of each other.
  double binomialVariance(uint32_t row, double exchange, double measure_area, double count_area) const;
  // Returns the standard error of a pair's exchange area from its spread over replicates alone. Of a single pair it
  // says little; over many pairs its squares have the right mean. It is 0 from a single replicate.
  double spreadOf(const PairSum& pair, double measure_area) const;
  // Returns the exchange area of one pair, which may have been summed elsewhere, in input units squared.
  //   In: is_rare: whether a replicate's directions meet the pair less than once on average
  Measured exchangeArea(const PairSum& pair, double measure_area, double count_area, bool is_rare = false) const;

  // Calls f(i, j, A_i F_ij) for every pair with a facing line, pairs with environment and leak included.
  template <class F>
  void forEachPair(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, exchangeArea(pair, measure_area, INFINITY));
  }

  // Returns the largest standard error over all form factors of the requested rows.
  double largestStandardError(double measure_area, double count_area = INFINITY) const;
  // Returns the largest standard error relative to its form factor, over form factors of at least `floor`.
  double largestRelativeError(double measure_area, double floor, double count_area = INFINITY) const;

 private:
  double varianceOf(const Sum& sum, uint64_t replicates) const;
  // Steps say in which steps a pair's counts grow: D_0 and the least D_1 of docs/method.md, eq. (12).
  struct Steps {
    double of_direction = 1;  // counts of a direction, or a ray, that meets the pair
    double least = 1;         // the least counts that come at a time
  };
  Steps stepsOf(const PairSum& pair, double count_area, bool is_rare) const;
  Measured measure(const Sum& sum, uint64_t replicates, const Steps& steps) const;
  template <class ErrorOf>
  double largestOf(const ErrorOf& error_of) const;

  Ids ids_;
  PairBlocks<PairSum> pairs_;
  std::vector<Sum> row_sums_;
  uint64_t replicate_count_ = 0;
  FurtherReplicates further_;
  std::vector<double> ray_areas_;   // by row, as in countRays(); empty: counts are along common directions
  std::vector<double> line_steps_;  // by row, as in setLineSteps(); empty: 1
};

// Returns the counts that a line adds on average where it meets a polygon, at least 1. A scanline adds no more than its
// chord; the mean projection of the polygon is taken for a square.
//   In: line: counts for the square of a spacing; area: of one side of the polygon; count_area: in the same units, the
//     area for which one count stands
double lineStep(double line, bool is_scanline, double area, double count_area);

// Returns a bound on the form factor of a pair that no line met, with 95 % confidence: docs/method.md, eq. (13).
//   In: area: the smaller area of the two ids, count_area: as above, both in input units squared; directions: number of
//     directions in all replicates
double unmetBound(double area, double count_area, double directions);

// Returns the counts added up by a coarser set of ids: id k becomes id_map[k].
PairCounts mergeIds(const PairCounts& counts, const std::vector<uint32_t>& id_map);

}  // namespace viewpeel
