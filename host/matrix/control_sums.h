// Counts with what closed forms know taken off: the same expectation up to a known number, and less noise.
//
// On every line two fronts that look at each other are facing (V) or blocked (O), and E[V + O] is known. With a share b fixed beforehand V - b (V + O) has a known
// difference from V in expectation, and where b is near the share of lines that nothing blocks it hardly varies.
#pragma once
#include <cstdint>
#include <vector>

#include "matrix/form_factors.h"

namespace viewpeel {

constexpr int kShareBits = 12;  // of a share
constexpr uint32_t kShareOne = 1u << kShareBits;

// The share of a pair's lines that nothing blocks, in units of 2^-kShareBits.
struct PairShare {
  uint32_t i, j;  // i < j
  uint32_t share;
};

// One replicate's V - b (V + O) of a pair, in units of 2^-kShareBits counts, and the sum over lines of the squares of what each adds.
struct ControlCount {
  __extension__ using Wide = unsigned __int128;
  uint32_t i, j;
  int64_t control;
  Wide squares;
};

//   In: shares sorted by (i, j); pairs without one, environment and leak have b = 0
std::vector<ControlCount> takeShares(const PairCounts& counts, const std::vector<PairShare>& shares);

// The controls of a coarser set of ids: id k becomes id_map[k].
std::vector<ControlCount> mergeIds(const std::vector<ControlCount>& controls, const std::vector<uint32_t>& id_map);

// What closed forms add back: b A_i F_ij with nothing in between.
struct KnownExchange {
  uint32_t i, j;
  double area;   // input units squared: b times the exchange area
  double most;   // the exchange area itself, which what is visible cannot exceed; infinite where not all of it is known
};

// Sums the controls of replicates, exactly.
class ControlSums {
 public:
  explicit ControlSums(Ids ids) : ids_(std::move(ids)) {}

  // Cost: O(nonzeros).
  void add(const std::vector<ControlCount>& controls);
  uint64_t replicateCount() const { return replicate_count_; }

  //   In: measure_area as in ReplicateSums; known: sorted by (i, j), every pair at most once
  //   Out: without row sums
  //   Error: unbiased but for the ends of [0, most], to which values are moved: the truth lies within. Standard errors as in ReplicateSums, with the squares in the place of
  //     counts, and never less than one line's.
  FormFactors formFactors(double measure_area, const std::vector<KnownExchange>& known) const;

 private:
  __extension__ using Wide = unsigned __int128;
  __extension__ using SignedWide = __int128;
  struct PairSum {
    uint32_t i, j;
    SignedWide sum = 0;
    Wide sum_of_squares = 0;  // over replicates
    Wide squares = 0;         // over lines
  };
  Ids ids_;
  std::vector<PairSum> pairs_;
  uint64_t replicate_count_ = 0;
};

// The controlled form factors, but those sampled whose standard error is less than half of theirs: where shares were told by too few lines, control adds noise. The factor 2 keeps
// chance out of it: of two equal standard errors from 8 replicates one comes out half the other in 1 of 25 cases.
//   In: of the same ids; row sums are those sampled
FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled);

// Of all form factors of the rows asked for.
double largestStandardError(const FormFactors& form_factors);
// The same relative to the form factor, over those of at least `floor`.
double largestRelativeError(const FormFactors& form_factors, double floor);

}  // namespace viewpeel
