// What a run has counted: what a checkpoint keeps, and what sums of several runs are made of.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"
#include "sums/replicate_sums.h"
#include "sums/prior_sums.h"

namespace viewpeel {

// Replicates first to end - 1.
struct ReplicateRange {
  uint64_t first = 0, end = 0;

  bool operator==(const ReplicateRange&) const = default;
};

// All that a result, and going on towards it, needs of the replicates done. Integers throughout: the order of
// replicates does not matter.
struct RunSums {
  ReplicateSums by_id;                     // row sums alone where `visible` has the pairs (hasPairsInVisible)
  ReplicateSums by_surface;                // the same counts summed by surface
  std::vector<ReplicateRange> replicates;  // sorted; a gap between each and the next
  uint64_t directions = 0;                 // in all, those of directed pairs not counted
  double measure_area = 0;                 // input units squared of one count; unknown, 0, before the first replicate
  std::optional<PriorSums> prior_sums{};   // with unoccluded form factors: by_id is by face then
  std::optional<LineSums>
      lines{};  // where all pairs have lines of their own: by_id is by face, for environment and leak

  uint64_t replicateCount() const { return by_id.replicateCount(); }
  // With unoccluded form factors by polygon: what counts alone say of a pair is among what its visibility is made of.
  bool hasPairsInVisible() const { return prior_sums && prior_sums->by() == By::polygon; }
  // Input units squared of one count along its direction; infinite, not known, where only some rows were asked for and
  // directions are drawn for them.
  double countArea() const;
  // False where something ended a call of add early, and for sums that do not go with each other.
  bool isWhole() const;

  //   In: a replicate that is not there yet; counts by id; of directed pairs (PriorSums) those along their own
  //   directions
  //   Cost: O(nonzeros log nonzeros).
  void add(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const PairCounts& directed = {});
  // The same of a run with lines.
  void addLines(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const LineCounts& line_counts);
  //   In: replicates that are not there yet, of the same run: the same ids, the same measure_area, the same
  //   visibilities
  //   Cost: O(nonzeros).
  void add(const RunSums& others);

  // What was counted comes to: with unoccluded form factors where there are, then of the ids asked for (PriorSums::by)
  // and with entries of 0 for pairs never seen, else of by_id.
  //   In: row: as in PriorSums
  FormFactors formFactors(const ExchangeRow& row = {}) const;
  // Only those by polygon whose unoccluded form factors are known, as they are among all; needs PriorSums.
  FormFactors priorFormFactors() const;
  FormFactors betweenSurfaces() const;
};

// Sums of no replicates.
RunSums makeRunSums(const Scene& scene, const Ids& ids);

// The first range of `b` that shares a replicate with `a`; an empty range where there is none.    In: both sorted
ReplicateRange findShared(const std::vector<ReplicateRange>& a, const std::vector<ReplicateRange>& b);

}  // namespace viewpeel
