// An EstimateRun computes an estimate in steps: it counts one replicate at a time, until the goal.
#pragma once
#include <optional>
#include <vector>

#include "estimator/estimate.h"
#include "stopwatch.h"

namespace viewpeel {

class EstimateRun {
 public:
  // Starts the run. If options.resumed holds the sums of an earlier run, this run continues it.
  //   In: engine, scene, ids: as for estimateFormFactors; the caller keeps them alive. options: callbacks are ignored.
  //   Throws: Error bad_usage, as estimateFormFactors.
  EstimateRun(Engine& engine, const Scene& scene, const Ids& ids, EstimateOptions options);

  // Returns true where the goal is reached, or the next replicate would end after the given time.
  bool isDone() const;
  // Returns true where the goal is reached. A run that ended for lack of time has not reached it.
  bool isReached() const;
  // Counts one replicate.    Throws: whatever the engine throws; the sums then stay as they were.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest standard error of all form factors so far. It is infinite without a goal, and before the least
  // number of replicates is done.
  double largestStandardError() const { return largest_error_; }
  // Returns the estimate of the replicates up to now.
  Estimate estimateSoFar() const;
  // Returns the same estimate. It may be called once, after the last step. It saves time, because it moves out the form
  // factors that this step has computed.
  Estimate takeEstimate();

 private:
  bool measure(const FormFactors& so_far);
  void resume();
  void measureErrors();
  void measureNow();
  DrawnDirections directionsOf(uint64_t replicate) const;

  Engine& engine_;
  EstimateOptions options_;
  double count_area_;
  RunSums sums_;
  std::vector<DirectedPair> directed_;
  ExchangeRow row_;  // unoccluded form factors of pairs outside the prior
  double largest_error_ = INFINITY, largest_relative_error_ = INFINITY, rms_error_ = INFINITY;
  std::optional<FormFactors> found_;  // once the goal is reached
  uint64_t resumed_count_ = 0;
  uint64_t next_measured_ = 0;  // replicates before which errors are not measured again
  Clock::time_point start_ = Clock::now();
};

}  // namespace viewpeel
