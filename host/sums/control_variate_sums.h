// Counts with what unoccluded form factors know taken off: the same expectation up to a known number, and less noise.
//
// On every line two fronts that look at each other are facing (V) or blocked (O), and E[V + O] is known. With a
// visibility b fixed beforehand V - b (V + O) has a known difference from V in expectation, and where b is near the
// share of lines that nothing blocks it hardly varies.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/replicate_sums.h"

namespace viewpeel {

constexpr int kVisibilityBits = 12;  // of a visibility
constexpr uint32_t kVisibilityOne = 1u << kVisibilityBits;

// The share of a pair's lines that nothing blocks, in units of 2^-kVisibilityBits.
struct PairVisibility {
  uint32_t i, j;  // i < j
  uint32_t visibility;
};

// One replicate's V - b (V + O) of a pair, in units of 2^-kVisibilityBits counts, and the sum over lines of the squares
// of what each adds.
struct ControlVariate {
  __extension__ using Wide = unsigned __int128;
  uint32_t i, j;
  int64_t control;
  Wide squares;
  uint64_t line = 1;  // counts that one line adds, at most
};

// Sets `blocked` of environment and leak to all other lines of their row: the number of all lines is known, for rows
// sum to 1.
//   In: others: pairs (i, environment or leak), sorted, of which other replicates counted lines: where these counts
//   have none, the
//     pair is added with 0 facing lines, for a replicate whose lines all go elsewhere tells of the pair, too
PairCounts withRows(PairCounts counts, std::span<const PairVisibility> others = {});

// Of a pair, or a row, in one replicate: with kVisibilityBits more the squares of 2^3 replicates are within 128 bits.
constexpr uint64_t kMostCounts = uint64_t(1) << 50;

// Throws: Error bad_usage where counts are too large for visibilities of them.
void requireCountsForVisibilities(const PairCount& count);

// Counts that one line adds to a pair: the less of its ids', where all of each is counted on one lattice.    In: lines:
// of each id; none: 1
uint64_t lineOf(const std::vector<uint64_t>& lines, uint32_t i, uint32_t j);

//   In: visibilities sorted by (i, j); pairs without one have b = 0; lines as in lineOf
//   Throws: as requireCountsForVisibilities.
std::vector<ControlVariate> takeControlVariates(const PairCounts& counts,
                                                const std::vector<PairVisibility>& visibilities,
                                                const std::vector<uint64_t>& lines = {});

// The controls of a coarser set of ids: id k becomes id_map[k].
std::vector<ControlVariate> mergeIds(const std::vector<ControlVariate>& controls, const std::vector<uint32_t>& id_map);

// What unoccluded form factors add back: b A_i F_ij with nothing in between.
struct PriorExchange {
  uint32_t i, j;
  double area;  // input units squared: b times the exchange area
  double most;  // the exchange area itself, which what is visible cannot exceed; infinite where not all of it is known
  uint64_t line = 1;  // as in ControlVariate
};

// The standard error of what replicates add up to, in counts.
//   In: variance: R s^2, of the sum of R replicates; squares: the sum over lines of the squares of what each adds;
//   line: what one adds; most: counts that a direction which sees the pair may
//     add: the smaller area over a count's
double errorOfSum(double variance, double squares, double line, double most);

// Of n directions none meets a pair with a probability of e^(-n F / 2) at most, F from the smaller of the two and with
// nothing in between, for E[A'] = F A / 2 and A' <= A. Where no line told anything but what was taken for granted,
// standard errors are raised to that times `most`.    In: area: the smaller of the two
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
  // As they were summed before.    In: pairs sorted by (i, j), every pair at most once
  ControlVariateSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs)
      : ids_(std::move(ids)), pairs_(std::move(pairs)), replicate_count_(replicate_count) {}

  // Throws: Error bad_usage where so many replicates with counts so large are beyond 128 bits.    Cost: O(nonzeros).
  void add(const std::vector<ControlVariate>& controls);
  // Controls of other replicates, with the same visibilities.    Throws: as above.
  void add(const ControlVariateSums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  uint64_t replicateCount() const { return replicate_count_; }

  // Calls f(i, j, variance) for every pair met, with the sample variance of single replicates' A_i F_ij; there have to
  // be two of them.
  template <class F>
  void forEachVariance(double measure_area, F f) const {
    for (const PairSum& pair : pairs_) f(pair.i, pair.j, variance(pair, measure_area));
  }

  //   In: measure_area, count_area as in ReplicateSums; prior: sorted by (i, j), every pair at most once
  //   Out: without row sums
  //   Error: unbiased but for the ends of [0, most], to which values are moved: the truth lies within. Standard errors
  //   as in ReplicateSums, with the squares in the place of
  //     counts: never less than one line's, and no more than the distance to the farther end. So a pair that no line
  //     met has a value of 0 and a standard error, too.
  FormFactors formFactors(double measure_area, const std::vector<PriorExchange>& prior,
                          double count_area = INFINITY) const;
  // The same, of pairs that no line told.
  FormFactors allowForUnmet(const FormFactors& form_factors, double measure_area,
                            const std::vector<PriorExchange>& prior, double count_area) const;
  // Both, of one pair.    Cost: O(log nonzeros).
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

// The controlled form factors, but those sampled whose standard error is less than half of theirs: where visibilities
// were told by too few lines, control adds noise. The factor 2 keeps chance out of it: of two equal standard errors
// from 8 replicates one comes out half the other in 1 of 25 cases.
//   In: of the same ids; row sums are those sampled
FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled);

// Of all form factors of the rows asked for.
double largestStandardError(const FormFactors& form_factors);
// The same relative to the form factor, over those of at least `floor`.
double largestRelativeError(const FormFactors& form_factors, double floor);

}  // namespace viewpeel
