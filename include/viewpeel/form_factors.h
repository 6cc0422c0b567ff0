// The form factors of a result are sparse and symmetric, and have standard errors.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/ids.h>

namespace viewpeel {

// Measured is a mean over R replicates and the standard error of this mean. Its 95 % interval is value +- t
// standard_error with Student's t of R - 1 degrees of freedom, 2.36 for 8 replicates. The spread of few replicates is
// itself uncertain. Coverage: bench/programs/coverage.cpp.
struct Measured {
  double value = 0;
  double standard_error = 0;
};

// An Interval holds a true value with the probability of a guarantee, all intervals of a result at once.
struct Interval {
  double lower = 0, upper = 0;
};

// FormFactors holds the form factors of n ids. One symmetric quantity is stored per pair, the exchange area A_i F_ij =
// A_j F_ji. So reciprocity holds by construction: exchangeArea(i, j) and exchangeArea(j, i) are one number.
class FormFactors {
 public:
  struct Entry {
    uint32_t i, j;           // i <= j; j may be kEnvironment or kLeak
    Measured exchange_area;  // input units squared
  };

  // Takes the entries as they are.
  //   In: entries sorted by (i, j), every pair at most once, input units squared; row_sums: one for each id; intervals:
  //   of a guarantee, one for each entry's exchange area, or none; unlisted_bound: of such intervals, on form factors
  //   of pairs without an entry, from the smaller id
  FormFactors(Ids ids, std::vector<Entry> entries, std::vector<Measured> row_sums, std::vector<Interval> intervals = {},
              double unlisted_bound = 0);

  const Ids& ids() const { return ids_; }
  // Returns the nonzero entries, sorted by (i, j).
  const std::vector<Entry>& entries() const& { return entries_; }
  std::vector<Entry> entries() && { return std::move(entries_); }

  // Returns A_i F_ij in input units squared.    Cost: O(log nonzeros).
  Measured exchangeArea(uint32_t i, uint32_t j) const;
  // Returns F_ij = A_i F_ij / A_i, the fraction of the radiation leaving i that reaches j directly. j may be
  // kEnvironment or kLeak.    Cost: O(log nonzeros).
  Measured formFactor(uint32_t i, uint32_t j) const;
  // Returns true where a guarantee gives every entry an interval.
  bool hasIntervals() const { return !intervals_.empty(); }
  // Returns the intervals of exchange areas, one for each entry, or none.
  const std::vector<Interval>& intervals() const { return intervals_; }
  // Returns the bound of a guarantee on form factors of pairs without an entry, from the smaller id.
  double unlistedBound() const { return unlisted_bound_; }
  // Returns the interval of F_ij. A pair without an entry is surely 0 after pair lines, and at most the bound of the
  // guarantee after common directions.    In: as formFactor    Cost: O(log nonzeros).
  Interval interval(uint32_t i, uint32_t j) const;
  // Returns sum_j F_ij of each row, environment and leak included; its expectation is 1.
  const std::vector<Measured>& rowSums() const { return row_sums_; }

 private:
  size_t find(uint32_t i, uint32_t j) const;

  Ids ids_;
  std::vector<Entry> entries_;
  std::vector<Measured> row_sums_;
  std::vector<Interval> intervals_;
  double unlisted_bound_ = 0;
};

}  // namespace viewpeel
