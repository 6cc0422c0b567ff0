// ControlVariateSums adds up, over replicates, the counts of pairs less their control variates, which have less
// variance than the counts.
//
// Of the lines on which the fronts of a pair look at each other, V are facing and O are blocked. E[V + O] is known: it
// is the unoccluded form factor (docs/method.md, eq. (14)). With a visibility b that is fixed beforehand, V - b (V + O)
// therefore differs from V by a known number in expectation (eq. (17)). It hardly varies where b is near V / (V + O).
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/replicate_sums.h"

namespace viewpeel {

constexpr int kVisibilityBits = 12;  // visibilities are integers in units of 2^-12
constexpr uint32_t kVisibilityOne = 1u << kVisibilityBits;

// A PairVisibility is the share of a pair's lines that nothing blocks.
struct PairVisibility {
  uint32_t i, j;        // i < j
  uint32_t visibility;  // in units of 2^-kVisibilityBits
};

// A ControlVariate is V - b (V + O) of one pair in one replicate, in units of 2^-kVisibilityBits counts.
struct ControlVariate {
  __extension__ using Wide = unsigned __int128;
  uint32_t i, j;
  int64_t control;
  Wide squares;       // sum over the replicate's lines of the squares of what each adds to `control`
  uint64_t line = 1;  // most counts that one line adds
};

// Returns the counts with `blocked` of each environment and leak set to all other lines of its row. V + O is then the
// number of all lines of the row, whose expectation is known, for rows sum to 1.
//   In: others: pairs of an id with environment or leak, sorted, which other replicates have counted. Where `counts`
//     lacks such a pair, it is added with 0 facing lines, because a replicate without such lines counts, too.
PairCounts withRows(PairCounts counts, std::span<const PairVisibility> others = {});

// The counts of a pair, or a row, in one replicate are at most this number. Multiplied by visibilities they have
// kVisibilityBits more, and the sum of the squares of 2^3 replicates still fits 128 bits.
constexpr uint64_t kMostCounts = uint64_t(1) << 50;

// Checks that counts are small enough for sums of their squares.
//   Throws: Error bad_usage where a count exceeds kMostCounts.
void requireCountsForVisibilities(const PairCount& count);

// Returns the number of counts that one line adds to a pair. A pair is counted on the finer lattice of its two ids,
// whose lines add fewer counts.
//   In: lines: uint64_t[ids], counts that a line of each id's lattice adds; empty: 1 for all
uint64_t lineOf(const std::vector<uint64_t>& lines, uint32_t i, uint32_t j);

// Returns the control variates of one replicate.
//   In: visibilities: sorted by (i, j); a pair without one has b = 0; lines: as in lineOf
//   Throws: as requireCountsForVisibilities.
std::vector<ControlVariate> takeControlVariates(const PairCounts& counts,
                                                const std::vector<PairVisibility>& visibilities,
                                                const std::vector<uint64_t>& lines = {});

// Adds the control variates up by a coarser set of ids: id k becomes id_map[k].
std::vector<ControlVariate> mergeIds(const std::vector<ControlVariate>& controls, const std::vector<uint32_t>& id_map);

// A PriorExchange is the known part b F0_ij A_i of a pair's exchange area, which is added to the sum of its control
// variates, eq. (17). Areas are in input units squared.
struct PriorExchange {
  uint32_t i, j;
  double area;        // b times the unoccluded exchange area
  double most;        // the unoccluded exchange area, which bounds the pair's; infinite where a part of it is unknown
  uint64_t line = 1;  // as in ControlVariate
};

// Returns the standard error of a sum over replicates, in counts: docs/method.md, eq. (12) with the squares of lines in
// the place of counts.
//   In: variance: R s^2, the variance of the sum of R replicates; squares: the sum, over all lines, of the squares of
//     what each adds; line: counts that one line adds; most: the most counts that a direction adds, which is the pair's
//     smaller area over the area of a count
double errorOfSum(double variance, double squares, double line, double most);

// Returns the exchange area with its standard error raised to eq. (18) times `most`, for a pair whose lines all agree
// with the prior. Eq. (18) bounds the probability that none of the directions met the pair.
//   In: directions: number of directions in all replicates; area: the smaller area of the two ids, input units squared
Measured allowForUnmet(Measured exchange, const PriorExchange& prior, double directions, double area);

// A ControlVariateSums holds the sums of control variates over replicates, in exact integers.
class ControlVariateSums {
 public:
  __extension__ using Wide = unsigned __int128;
  __extension__ using SignedWide = __int128;
  struct PairSum {
    uint32_t i, j;
    SignedWide sum = 0;
    Wide sum_of_squares = 0;  // sum over replicates of ControlVariate::control squared
    Wide squares = 0;         // sum over replicates of ControlVariate::squares
    uint64_t line = 1;        // largest ControlVariate::line
  };

  explicit ControlVariateSums(Ids ids) : ids_(std::move(ids)) {}
  // Restores sums from a checkpoint.    In: pairs: sorted by (i, j), every pair at most once
  ControlVariateSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs)
      : ids_(std::move(ids)), pairs_(std::move(pairs)), replicate_count_(replicate_count) {}

  // Adds one replicate.
  //   Throws: Error bad_usage where a sum of squares would exceed 128 bits.    Cost: O(pairs).
  void add(const std::vector<ControlVariate>& controls);
  // Adds the sums of other replicates, which have the same visibilities.
  //   Throws: Error bad_usage where a sum of squares would exceed 128 bits.    Cost: O(pairs).
  void add(const ControlVariateSums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  uint64_t replicateCount() const { return replicate_count_; }

  // Calls f(i, j, variance) for every pair with sums. The variance is the sample variance of A_i F_ij of single
  // replicates, of which there must be at least two.
  template <class F>
  void forEachVariance(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, variance(pair, measure_area));
  }

  // Returns form factors: the mean of the control variates, plus PriorExchange::area.
  //   In: measure_area, count_area: as in ReplicateSums; prior: sorted by (i, j), every pair at most once
  //   Out: entries of all pairs with sums or in `prior`; no row sums
  //   Error: unbiased, except that values are moved into [0, most], where the truth lies. Standard errors are as in
  //     ReplicateSums, with squares instead of counts. They are at least one line's, and at most the distance to the
  //     farther end of [0, most]. So a pair that no line met has a standard error, too.
  FormFactors formFactors(double measure_area, const std::vector<PriorExchange>& prior,
                          double count_area = INFINITY) const;
  // Returns the form factors after the function allowForUnmet above has raised the standard errors of all pairs whose
  // lines agree with the prior.
  FormFactors allowForUnmet(const FormFactors& form_factors, double measure_area,
                            const std::vector<PriorExchange>& prior, double count_area) const;
  // Returns the exchange area of one pair, as formFactors and then allowForUnmet would find it.    Cost: O(log pairs).
  Measured exchangeArea(double measure_area, const PriorExchange& prior, double count_area = INFINITY) const;

 private:
  double variance(const PairSum& pair, double measure_area) const;
  Measured allowForUnmetPair(const Measured& exchange, double measure_area, const PriorExchange& prior,
                             double count_area) const;
  Measured measure(const PairSum& pair, double measure_area, const PriorExchange* prior, double count_area) const;

  Ids ids_;
  std::vector<PairSum> pairs_;
  uint64_t replicate_count_ = 0;
};

// Returns for each pair the entry from control variates, or the entry from counts alone where its standard error is
// less than half as large. Control variates add noise where visibilities come from too few lines. The factor 2 makes
// choices by chance rare: from 8 replicates, one of two equal standard errors is below half the other in 1 of 25
// cases.
//   In: controlled, sampled: form factors of the same ids and replicates    Out: form factors with the row sums of
//     `sampled`
FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled);

// Returns the largest standard error over all form factors of the requested rows.
double largestStandardError(const FormFactors& form_factors);
// Returns the largest standard error relative to its form factor, over form factors of at least `floor`.
double largestRelativeError(const FormFactors& form_factors, double floor);

}  // namespace viewpeel
