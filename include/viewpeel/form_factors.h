// FormFactors stores the form factors of a result sparsely, each with its standard error.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/ids.h>

namespace viewpeel {

// A Measured is a mean over R replicates, with its standard error. The 95 % interval is value +- t standard_error.
// Student's t has R - 1 degrees of freedom, because few replicates measure their spread badly: t is 2.36 for 8
// replicates. Coverage: bench/programs/coverage.cpp.
struct Measured {
  double value = 0;
  double standard_error = 0;
};

// An Interval of a guarantee holds the true value. All intervals of a result hold together with the guarantee's
// probability.
struct Interval {
  double lower = 0, upper = 0;
};

// FormFactors holds the form factors of n ids. It stores one number per pair, the exchange area A_i F_ij = A_j F_ji. So
// reciprocity is exact.
class FormFactors {
 public:
  struct Entry {
    uint32_t i, j;           // i <= j; j may be kEnvironment or kLeak
    Measured exchange_area;  // input units squared
    // This is the root mean square error that the entry adds to a sum over many entries. It may be smaller than the
    // standard error, which leaves a margin for what the entry's few lines may have missed. 0 stands for the standard
    // error.
    double error_in_sums = 0;

    double errorInSums() const { return error_in_sums > 0 ? error_in_sums : exchange_area.standard_error; }
    // Returns the margin, the part of the variance that errors in sums leave out, in input units to the fourth power.
    double margin() const {
      const double whole = exchange_area.standard_error, in_sums = errorInSums();
      return whole > in_sums ? (whole - in_sums) * (whole + in_sums) : 0;
    }
  };

  // Stores the entries.
  //   In: entries: sorted by (i, j), every pair at most once, in input units squared; row_sums: sum_j F_ij of each id;
  //     intervals: of the exchange area of each entry, for a guarantee, else none; unlisted_bound: with intervals, a
  //     bound on the form factor, from the smaller id, of every pair without an entry
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
  // Returns the bound that a guarantee gives for pairs without an entry, on the form factor from the smaller id.
  double unlistedBound() const { return unlisted_bound_; }
  // Returns the interval of F_ij. For a pair without an entry it is [0, unlistedBound() scaled to row i].
  //   In: i, j: as for formFactor    Cost: O(log nonzeros).
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
