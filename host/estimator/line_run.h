// A LineRun draws pair lines until the goal is reached, one replicate a step.
//
// Form factors between faces come from pair lines (pair_lines.h): of all pairs, or of pairs whose unoccluded form
// factor is large enough. Common directions count the other pairs, or rays of each polygon's own do. They also tell
// which rows see the environment and where lines leak.
#pragma once
#include <deque>
#include <functional>
#include <optional>

#include "estimator/estimate.h"
#include "estimator/line_mixture.h"
#include "estimator/plan_lines.h"
#include "pair_lines/pair_lines.h"
#include "stopwatch.h"

namespace viewpeel {

class LineRun {
 public:
  // Begins a run, or continues options.resumed.
  //   In: engine, face_ids: for common directions or rays; lines: after planLines; pairs: from planLines, ignored with
  //   options.resumed; all but pairs are kept by reference. least_form_factor: as in LineSums, of these pairs. options:
  //   goals, replicates, first_replicate, seed, sampler, directions, resumed, by
  LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
          double least_form_factor, EstimateOptions options);

  // Returns whether the goal is reached, or the next replicate would end after the time limit.
  bool isDone() const;
  // Returns whether the goal is reached, in time or too late.
  bool isReached() const { return is_reached_; }
  // Counts one replicate, or several in which only rows that miss the goal have rays.
  //   Throws: as the engine; the sums then stay as they were.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest standard error so far; infinite before the least number of replicates is done.
  double largestStandardError() const { return largest_error_; }
  Estimate estimate() const;

  // Returns how many planned replicates may have their lines and rays drawn at once. These are few where a replicate
  // has many lines or rays: while they are drawn, the run can neither end nor be saved.
  double mostAhead() const;
  // Returns whether lines of further replicates have been drawn with those of the last one.
  bool hasDrawnAhead() const { return !ahead_.empty(); }

 private:
  // Ahead is what has been drawn of a replicate before it is added.
  struct Ahead {
    LineCounts lines;
    std::optional<PairCounts> counts;  // along its rays
  };
  void measureErrors();
  void measureErrorsOfMixture();
  void planFurtherForRms(double of_lines, double of_counts);
  using Wanting = std::vector<std::pair<std::pair<uint32_t, uint32_t>, double>>;
  void noteErrorsBesideLines(const Wanting& wanting);
  bool hasCountedPairs() const { return sums_.lines->leastFormFactor() > 0; }
  std::vector<bool> findLeaksByLines() const;
  void planFurtherRays(uint32_t row, double excess);
  void planFurtherCountsOfLeaks(const FormFactors& all, const std::vector<bool>& leak_by_lines);
  std::vector<double> findRowExcess(const FormFactors& all, const std::vector<bool>& leak_by_lines) const;
  std::vector<double> findRowExcessOfLines() const;
  Wanting findWanting(const FormFactors& all) const;
  Wanting findWantingBetweenSurfaces(const FormFactors& all);
  std::vector<double> excessOfPairs(const Wanting& wanting, const std::vector<double>& row_excess) const;
  void planFurther(const std::vector<double>& excess, double relief);
  void planFurtherInTime(const std::vector<double>& excess);
  double secondsLeft() const { return options_.seconds ? *options_.seconds - secondsSince(start_) : INFINITY; }
  double secondsOfNext() const;
  bool mayGoOn() const;
  double excessOf(const FormFactors::Entry& entry, const Ids& ids) const;
  double excessOfCounts(const FormFactors::Entry& entry, const Ids& ids) const;
  double furtherLines() const;
  size_t replicatesAhead() const;
  // Only rows whose environment or leak, by rays, misses the goal get rays after the planned replicates. All rows do
  // where the goal is about all errors, and where rays count pairs between surfaces.
  bool hasFurtherRays() const {
    return options_.rays && !options_.rms && (options_.by == By::polygon || !hasCountedPairs());
  }
  const ReplicateSums& sumsOfRows() const { return options_.by == By::polygon ? sums_.by_id : sums_.by_surface; }
  std::vector<Direction> directionsOf(uint64_t replicate, size_t replicates) const;
  std::vector<PairCounts> countReplicates(uint64_t replicate, size_t replicates) const;
  void drawAhead(uint64_t replicate);
  void addReplicate(uint64_t replicate, Ahead& drawn);
  void castFurtherRays(uint64_t replicate, const LineCounts& lines);

  Engine& engine_;
  PairLines& lines_;
  EstimateOptions options_;
  double count_area_;
  RunSums sums_;
  ErrorsInGoal errors_in_goal_;
  double largest_error_ = INFINITY;
  bool is_further_ = false;  // whether the next replicate is a further one, for the planned ones miss the goal
  // further_[k] is how many times pair k draws its planned lines in that replicate. Empty when no pair needs more.
  std::vector<uint32_t> further_;
  std::deque<Ahead> ahead_;  // the next replicates
  // further_rays_[row] is how many of the next replicates have rays of this row of the result.
  std::vector<uint32_t> further_rays_;
  bool needs_directions_ = false;  // whether counts along directions or rays err by more than the goal allows
  bool is_reached_ = false;        // whether all pairs have the lines, and the directions, that their goal needs
  uint64_t resumed_count_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace viewpeel
