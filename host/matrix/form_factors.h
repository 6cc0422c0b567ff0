// The result: sparse, symmetric, with standard errors.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "matrix/ids.h"
#include "matrix/pair_count.h"

namespace viewpeel {

// A mean over R replicates and the standard error of that mean. Its 95 % interval is value +- t standard_error with Student's t of R - 1 degrees of
// freedom, 2.36 for 8 replicates: the spread of a few replicates is itself uncertain. Coverage: bench/coverage.cpp.
struct Measured {
  double value = 0;
  double standard_error = 0;
};

// Form factors of n ids. One symmetric quantity is stored per pair, the exchange area A_i F_ij = A_j F_ji, so that reciprocity
// holds by construction: exchangeArea(i, j) and exchangeArea(j, i) are one number.
class FormFactors {
 public:
  struct Entry {
    uint32_t i, j;  // i <= j; j may be kEnvironment or kLeak
    Measured exchange_area;  // input units squared
  };

  FormFactors(Ids ids, std::vector<Entry> entries, std::vector<Measured> row_sums);

  const Ids& ids() const { return ids_; }
  // Nonzero entries sorted by (i, j).
  const std::vector<Entry>& entries() const& { return entries_; }
  std::vector<Entry> entries() && { return std::move(entries_); }

  // A_i F_ij in input units squared. Cost: O(log nonzeros).
  Measured exchangeArea(uint32_t i, uint32_t j) const;
  // F_ij = A_i F_ij / A_i, the fraction of what leaves i that reaches j directly; j may be kEnvironment or kLeak.
  Measured formFactor(uint32_t i, uint32_t j) const;
  // sum_j F_ij, environment and leak included; its expectation is 1.
  const std::vector<Measured>& rowSums() const { return row_sums_; }

 private:
  Ids ids_;
  std::vector<Entry> entries_;
  std::vector<Measured> row_sums_;
};

// Sums the counts of replicates, exactly, and turns them into form factors.
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
  // As they were summed before.    In: pairs sorted by (i, j), every pair at most once; row_sums: one for each id
  ReplicateSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs, std::vector<Sum> row_sums)
      : ids_(std::move(ids)), pairs_(std::move(pairs)), row_sums_(std::move(row_sums)), replicate_count_(replicate_count) {}

  // Cost: O(nonzeros).
  void add(const PairCounts& counts);
  // Without pairs, where others sum them: row sums alone.
  void addRows(const PairCounts& counts);
  // Sums of other replicates.    In: others of the same ids    Cost: O(nonzeros).
  void add(const ReplicateSums& others);

  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  const std::vector<Sum>& rowSums() const { return row_sums_; }
  uint64_t replicateCount() const { return replicate_count_; }

  //   In: measure_area: input units squared of one count, that is unitArea() scale^2 / directions per replicate
  //     count_area: of one count along its direction, measure_area x directions per replicate where these are over the whole sphere; infinite where it is not known
  //   Error: none but rounding: counts and their squares are summed in 128-bit integers. Standard errors: form_factors.cpp; tests/form_factors_test.cpp.
  FormFactors formFactors(double measure_area, double count_area = INFINITY) const;
  // The same of one pair, whose counts were summed elsewhere.
  Measured exchangeArea(const PairSum& pair, double measure_area, double count_area) const;

  // Calls f(i, j, A_i F_ij) for every pair met, and for environment and leak.
  template <class F>
  void forEachPair(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, exchangeArea(pair, measure_area, INFINITY));
  }

  // Largest standard error over all form factors of the rows asked for.
  double largestStandardError(double measure_area, double count_area = INFINITY) const;
  // The same relative to the form factor, over form factors of at least `floor`.
  double largestRelativeError(double measure_area, double floor, double count_area = INFINITY) const;

 private:
  Measured measure(const Sum& sum, double most_counts) const;

  Ids ids_;
  std::vector<PairSum> pairs_;
  std::vector<Sum> row_sums_;
  uint64_t replicate_count_ = 0;
};

// What a form factor of an id of this area, the smaller of its pair, is at most where none of so many directions met it: with 95 % confidence (form_factors.cpp).
double unmetBound(double area, double count_area, double directions);

// The counts of a coarser set of ids: id k becomes id_map[k].
PairCounts mergeIds(const PairCounts& counts, const std::vector<uint32_t>& id_map);

}  // namespace viewpeel
