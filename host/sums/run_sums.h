// RunSums holds all sums of a run: a result, or the rest of the run, needs nothing else of the replicates done.
// Checkpoints store it, and RunSums of several parts of a run can be added.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include <viewpeel/form_factors.h>
#include "sums/line_sums.h"
#include "sums/replicate_sums.h"
#include "sums/prior_sums.h"

namespace viewpeel {

// A ReplicateRange stands for the replicates with the numbers `first` to end - 1.
struct ReplicateRange {
  uint64_t first = 0, end = 0;

  bool operator==(const ReplicateRange&) const = default;
};

// All sums are integers, so they do not depend on the order of replicates.
struct RunSums {
  // Counts are summed by id here. There are only row sums where hasPairsInVisible() holds. In runs with pair lines only
  // counts without lines are here: environment, leak, and pairs below LineSums::leastFormFactor().
  ReplicateSums by_id;
  ReplicateSums by_surface;                // the same counts added up by surface
  std::vector<ReplicateRange> replicates;  // replicates done: sorted, with a gap between ranges
  uint64_t directions = 0;                 // common directions of all replicates
  double measure_area = 0;                 // as in ReplicateSums, input units squared; 0 before the first replicate
  std::optional<PriorSums> prior_sums{};   // in runs that use unoccluded form factors; ids of by_id are faces then
  // A run with pair lines has their sums here. Ids of by_id are faces then.
  std::optional<LineSums> lines{};
  std::vector<uint32_t> rays{};      // by face, of a replicate, where by_id counts rays (ray_engine.h); else empty
  std::vector<double> line_steps{};  // by id, as in ReplicateSums::setLineSteps(); empty: 1

  uint64_t replicateCount() const { return by_id.replicateCount(); }
  // Returns whether PriorSums::byFace has the counts of all pairs: in runs by polygon that use unoccluded form factors.
  bool hasPairsInVisible() const { return prior_sums && prior_sums->by() == By::polygon; }
  // Returns count_area as in ReplicateSums, in input units squared. It is infinite, which stands for unknown, where
  // only some rows are requested, because directions may then be drawn for these rows.
  double countArea() const;
  // Returns whether all sums have the same replicates. They differ where an exception has ended a call of add early.
  bool isWhole() const;

  // Says that counts are of rays: ReplicateSums::countRays.    In: of_faces: uint32_t[ids of by_id]
  void countRays(std::vector<uint32_t> of_faces);
  // Says what one line adds: ReplicateSums::setLineSteps.    In: of_ids: double[ids of by_id]
  void setLineSteps(std::vector<double> of_ids);
  // Adds one replicate.
  //   In: replicate: its number, not among `replicates`; counts: along common directions, by id; direction_count:
  //     number of these directions; directed: counts of directed pairs along their directions
  //   Cost: O(n log n) for n counts.
  void add(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const PairCounts& directed = {});
  // Adds one replicate of a run with pair lines.    In: as in add; line_counts: sums of the pair lines
  void addLines(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const LineCounts& line_counts);
  // Adds one replicate in which only some rows of the result had rays, for their environment and leak.
  //   In: as in addLines; rows: bool[rows of the result]; all faces of these rows had rays
  void addOutside(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const LineCounts& line_counts,
                  const std::vector<bool>& rows);
  // Adds other replicates of the same run.
  //   In: others: with none of this one's replicates; with the same ids, measure_area and prior visibilities
  //   Cost: O(pairs).
  void add(const RunSums& others);

  // Returns the form factors of the run, by the rows of the result. With prior_sums, pairs that no line met have
  // entries, too.
  //   In: row: as in PriorSums::byPolygon
  FormFactors formFactors(const ExchangeRow& row = {}) const;
  // Returns the form factors by polygon of only the pairs of the prior that are not estimated by counts alone, before
  // guesses are made to fit their rows. Needs prior_sums.
  FormFactors priorFormFactors() const;
  // Returns the form factors between surfaces.
  FormFactors betweenSurfaces() const;

 private:
  void note(uint64_t replicate, uint64_t direction_count);
};

// Makes the sums of a run to which no replicate has been added yet.
RunSums makeRunSums(const Scene& scene, const Ids& ids);

// Returns the replicates that `a` and `b` share, of the first range of `b` that shares any; an empty range where none
// does.    In: a, b: sorted
ReplicateRange findShared(const std::vector<ReplicateRange>& a, const std::vector<ReplicateRange>& b);

}  // namespace viewpeel
