// RunSums holds the counts of a run. A checkpoint keeps it, and RunSums of several runs add up.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"
#include "sums/replicate_sums.h"
#include "sums/prior_sums.h"

namespace viewpeel {

// The range has the replicates first to end - 1.
struct ReplicateRange {
  uint64_t first = 0, end = 0;

  bool operator==(const ReplicateRange&) const = default;
};

// A result, and a run that goes on towards it, needs no more of the replicates done. Integers throughout: the order of
// replicates does not matter.
struct RunSums {
  ReplicateSums by_id;                     // row sums alone where prior_sums has the pairs (hasPairsInVisible)
  ReplicateSums by_surface;                // the same counts summed by surface
  std::vector<ReplicateRange> replicates;  // sorted; a gap between each and the next
  uint64_t directions = 0;                 // in all, without directions of directed pairs
  double measure_area = 0;                 // input units squared of one count; 0 before the first replicate
  std::optional<PriorSums> prior_sums{};   // with unoccluded form factors: by_id is by face then
  std::optional<LineSums>
      lines{};  // where all pairs have lines of their own: by_id is by face, for environment and leak

  uint64_t replicateCount() const { return by_id.replicateCount(); }
  // Returns true with unoccluded form factors by polygon: their visibilities contain the counts of pairs.
  bool hasPairsInVisible() const { return prior_sums && prior_sums->by() == By::polygon; }
  // Returns input units squared of one count along its direction. It is infinite, for unknown, where the request has
  // only some rows and directions are drawn for them.
  double countArea() const;
  // Returns false where something ended a call of add early, and for sums that do not go with each other.
  bool isWhole() const;

  // Adds one replicate.
  //   In: a replicate that is not there yet; counts by id; of directed pairs (PriorSums) the counts along their own
  //     directions
  //   Cost: O(nonzeros log nonzeros).
  void add(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const PairCounts& directed = {});
  // Adds one replicate of a run with lines.
  void addLines(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const LineCounts& line_counts);
  // Adds other replicates of the same run.
  //   In: replicates that are not there yet; the same ids, the same measure_area, the same visibilities
  //   Cost: O(nonzeros).
  void add(const RunSums& others);

  // Finds the form factors of all counts. With prior_sums they are of the ids of PriorSums::by, and have entries of 0
  // for pairs never seen; else they are of by_id.
  //   In: row: as in PriorSums
  FormFactors formFactors(const ExchangeRow& row = {}) const;
  // Finds only the form factors by polygon of the prior's pairs, as they are among all; needs PriorSums.
  FormFactors priorFormFactors() const;
  FormFactors betweenSurfaces() const;
};

// Makes sums of no replicates.
RunSums makeRunSums(const Scene& scene, const Ids& ids);

// Returns the first range of `b` that shares a replicate with `a`; an empty range where there is none.    In: both
// sorted
ReplicateRange findShared(const std::vector<ReplicateRange>& a, const std::vector<ReplicateRange>& b);

}  // namespace viewpeel
