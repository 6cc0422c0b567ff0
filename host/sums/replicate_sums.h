// ReplicateSums adds up counts over replicates, and estimates form factors from them.
#pragma once
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/ids.h>
#include "sums/pair_count.h"

namespace viewpeel {

// All sums are exact, in 128-bit integers.
class ReplicateSums {
 public:
  __extension__ using Wide = unsigned __int128;
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

  explicit ReplicateSums(Ids ids) : ids_(std::move(ids)), row_sums_(ids_.count()) {}
  // Restores sums from a checkpoint.    In: pairs sorted by (i, j), every pair at most once; row_sums: one for each id
  ReplicateSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs, std::vector<Sum> row_sums)
      : ids_(std::move(ids)),
        pairs_(std::move(pairs)),
        row_sums_(std::move(row_sums)),
        replicate_count_(replicate_count) {}

  // Adds one replicate.    Cost: O(nonzeros).
  void add(const PairCounts& counts);
  // Adds one replicate to the row sums alone, where others sum its pairs.
  void addRows(const PairCounts& counts);
  // Adds sums of other replicates.    In: others of the same ids    Cost: O(nonzeros).
  void add(const ReplicateSums& others);

  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  const std::vector<Sum>& rowSums() const { return row_sums_; }
  uint64_t replicateCount() const { return replicate_count_; }

  // Finds the form factors of all pairs that a line hit.
  //   In: measure_area: input units squared of one count, which is unitArea() scale^2 / directions per replicate
  //   count_area: of one count along its direction, measure_area x directions per replicate where directions are over
  //     the whole sphere; infinite where it is unknown
  //   Error: none but rounding: counts and their squares are summed in 128-bit integers. Standard errors:
  //     docs/method.md, eq. (12); tests/unit/form_factors_test.cpp.
  FormFactors formFactors(double measure_area, double count_area = INFINITY) const;
  // Finds the exchange area of one pair, whose counts were summed elsewhere.
  Measured exchangeArea(const PairSum& pair, double measure_area, double count_area) const;

  // Calls f(i, j, A_i F_ij) for every pair with an entry, and for environment and leak.
  template <class F>
  void forEachPair(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, exchangeArea(pair, measure_area, INFINITY));
  }

  // Returns the largest standard error over all form factors of the request's rows.
  double largestStandardError(double measure_area, double count_area = INFINITY) const;
  // Returns the largest relative to the form factor, over form factors of at least `floor`.
  double largestRelativeError(double measure_area, double floor, double count_area = INFINITY) const;

 private:
  Measured measure(const Sum& sum, double most_counts) const;

  Ids ids_;
  std::vector<PairSum> pairs_;
  std::vector<Sum> row_sums_;
  uint64_t replicate_count_ = 0;
};

// Returns a bound on the form factor of a pair that none of `directions` hit, with 95 % confidence: docs/method.md, eq.
// (13).    In: area: of the smaller id of its pair
double unmetBound(double area, double count_area, double directions);

// Sums the counts by a coarser set of ids: id k becomes id_map[k].
PairCounts mergeIds(const PairCounts& counts, const std::vector<uint32_t>& id_map);

}  // namespace viewpeel
