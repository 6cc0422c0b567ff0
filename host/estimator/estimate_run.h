// An EstimateRun computes an estimate in steps: it counts one replicate at a time, until the goal.
#pragma once
#include <optional>
#include <vector>

#include "estimator/estimate.h"
#include "stopwatch.h"

namespace viewpeel {

class EstimateRun {
 public:
  // Starts the run, from the sums of an earlier one where options have them.
  //   In: engine, scene, ids: as for estimateFormFactors, referred to; options: without the callbacks
  //   Throws: Error bad_usage, as estimateFormFactors.
  EstimateRun(Engine& engine, const Scene& scene, const Ids& ids, EstimateOptions options);

  // Returns true where the goal is reached, or the next replicate would end after the time.
  bool isDone() const;
  // Returns true where the goal is reached, in time or not.
  bool isReached() const;
  // Counts one replicate.    Throws: what the engine throws; the sums are then as before.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest standard error of all form factors so far. It is infinite without a goal, and before the least
  // number of replicates is done.
  double largestStandardError() const { return largest_error_; }
  // Returns the estimate of the replicates up to now.
  Estimate estimateSoFar() const;
  // Returns the same estimate, once no step is to follow: the form factors that reached the goal are not computed
  // again.
  Estimate takeEstimate();

 private:
  bool measure(const FormFactors& so_far);
  void resume();
  void measureErrors();
  DrawnDirections directionsOf(uint64_t replicate) const;

  Engine& engine_;
  EstimateOptions options_;
  double count_area_;
  RunSums sums_;
  std::vector<DirectedPair> directed_;
  ExchangeRow row_;  // unoccluded form factors of pairs outside the prior
  double largest_error_ = INFINITY, largest_relative_error_ = INFINITY;
  std::optional<FormFactors> found_;  // once the goal is reached
  uint64_t resumed_count_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace viewpeel
