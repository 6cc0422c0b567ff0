// ControlVariateSums adds up counts less their control variates: the same expectation up to a given number, and less
// noise.
//
// On every line two fronts that look at each other are facing (V) or blocked (O), and E[V + O] is given
// (docs/method.md, eq. (14)). With a visibility b fixed beforehand V - b (V + O) differs from V by a given number in
// expectation (eq. (17)). It hardly varies where b is near the share of lines that nothing blocks.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/replicate_sums.h"

namespace viewpeel {

constexpr int kVisibilityBits = 12;  // of a visibility
constexpr uint32_t kVisibilityOne = 1u << kVisibilityBits;

// PairVisibility is the share of a pair's lines that nothing blocks, in units of 2^-kVisibilityBits.
struct PairVisibility {
  uint32_t i, j;  // i < j
  uint32_t visibility;
};

// A ControlVariate is one replicate's V - b (V + O) of a pair, in units of 2^-kVisibilityBits counts. `squares` sums
// the squares of the terms that lines add.
struct ControlVariate {
  __extension__ using Wide = unsigned __int128;
  uint32_t i, j;
  int64_t control;
  Wide squares;
  uint64_t line = 1;  // counts that one line adds, at most
};

// Sets `blocked` of environment and leak to all other lines of their row. The number of all lines is given, for rows
// sum to 1.
//   In: others: pairs (i, environment or leak), sorted, of which other replicates counted lines. Where these counts
//     have no such pair it is added with 0 facing lines, for a replicate whose lines all go elsewhere counts, too.
PairCounts withRows(PairCounts counts, std::span<const PairVisibility> others = {});

// The counts of a pair, or a row, in one replicate are at most this many. With kVisibilityBits more the squares of 2^3
// replicates are within 128 bits.
constexpr uint64_t kMostCounts = uint64_t(1) << 50;

// Refuses counts beyond kMostCounts.
//   Throws: Error bad_usage where counts are too large for visibilities of them.
void requireCountsForVisibilities(const PairCount& count);

// Returns the counts that one line adds to a pair: the less of its ids', where all of each is counted on one lattice.
//   In: lines: of each id; none: 1
uint64_t lineOf(const std::vector<uint64_t>& lines, uint32_t i, uint32_t j);

// Returns the control variates of one replicate.
//   In: visibilities sorted by (i, j); pairs without one have b = 0; lines as in lineOf
//   Throws: as requireCountsForVisibilities.
std::vector<ControlVariate> takeControlVariates(const PairCounts& counts,
                                                const std::vector<PairVisibility>& visibilities,
                                                const std::vector<uint64_t>& lines = {});

// Sums the controls by a coarser set of ids: id k becomes id_map[k].
std::vector<ControlVariate> mergeIds(const std::vector<ControlVariate>& controls, const std::vector<uint32_t>& id_map);

// A PriorExchange is the part that unoccluded form factors add back: b A_i F_ij with nothing in between.
struct PriorExchange {
  uint32_t i, j;
  double area;  // input units squared: b times the exchange area
  // The visible part cannot exceed the exchange area itself. It is infinite where some of it is unknown.
  double most;
  uint64_t line = 1;  // as in ControlVariate
};

// Returns the standard error of a sum over replicates, in counts: docs/method.md, eq. (12) with the squares of lines in
// the place of counts.
//   In: variance: R s^2, of the sum of R replicates; squares: the sum over lines of the squares of their terms; line:
//     counts of one line; most: the most counts of a direction that sees the pair, the smaller area over a count's
double errorOfSum(double variance, double squares, double line, double most);

// Raises the standard error to eq. (18) times `most` where all lines agree with the prior. None of n directions hits
// such a pair with the probability (18), at most.    In: area: the smaller of the two
Measured allowForUnmet(Measured exchange, const PriorExchange& prior, double directions, double area);

// Sums the controls of replicates, exactly.
class ControlVariateSums {
 public:
  __extension__ using Wide = unsigned __int128;
  __extension__ using SignedWide = __int128;
  struct PairSum {
    uint32_t i, j;
    SignedWide sum = 0;
    Wide sum_of_squares = 0;  // over replicates
    Wide squares = 0;         // over lines
    uint64_t line = 1;
  };

  explicit ControlVariateSums(Ids ids) : ids_(std::move(ids)) {}
  // Restores sums from a checkpoint.    In: pairs sorted by (i, j), every pair at most once
  ControlVariateSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs)
      : ids_(std::move(ids)), pairs_(std::move(pairs)), replicate_count_(replicate_count) {}

  // Adds one replicate.    Throws: Error bad_usage where this many replicates with counts as large are beyond 128 bits.
  // Cost: O(nonzeros).
  void add(const std::vector<ControlVariate>& controls);
  // Adds controls of other replicates, with the same visibilities.    Throws: as above.
  void add(const ControlVariateSums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  uint64_t replicateCount() const { return replicate_count_; }

  // Calls f(i, j, variance) for every pair with an entry, with the sample variance of single replicates' A_i F_ij. It
  // needs two replicates.
  template <class F>
  void forEachVariance(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, variance(pair, measure_area));
  }

  // Finds the form factors of the controls.
  //   In: measure_area, count_area as in ReplicateSums; prior: sorted by (i, j), every pair at most once
  //   Out: without row sums
  //   Error: unbiased but for the ends of [0, most], to which values are moved: the truth lies within. Standard errors
  //     are as in ReplicateSums, with the squares in the place of counts. They are never less than one line's, nor more
  //     than the distance to the farther end. So a pair that no line hit has a value of 0 and a standard error, too.
  FormFactors formFactors(double measure_area, const std::vector<PriorExchange>& prior,
                          double count_area = INFINITY) const;
  // Raises the standard errors of pairs whose lines all agree with the prior, by the function of the same name.
  FormFactors allowForUnmet(const FormFactors& form_factors, double measure_area,
                            const std::vector<PriorExchange>& prior, double count_area) const;
  // Finds the exchange area of one pair, with both of these steps.    Cost: O(log nonzeros).
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

// Takes the controlled form factors, but those sampled whose standard error is less than half of theirs. Where
// visibilities come from too few lines, control adds noise. The factor 2 keeps chance out: of two equal standard errors
// from 8 replicates one comes out half the other in 1 of 25 cases.
//   In: of the same ids; row sums are those sampled
FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled);

// Returns the largest of all form factors of the request's rows.
double largestStandardError(const FormFactors& form_factors);
// Returns the largest relative to the form factor, over form factors of at least `floor`.
double largestRelativeError(const FormFactors& form_factors, double floor);

}  // namespace viewpeel
