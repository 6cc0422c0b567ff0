// A GuaranteeRun carries out guarantee mode in steps. Each step counts some blocks of directions, until Hoeffding's or
// Bernstein's bound is at most epsilon.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

class GuaranteeRun {
 public:
  // Starts the run. If options.resumed holds the sums of an earlier run, this run continues it.
  //   In: ids, plan: the caller keeps both alive, and the plan's engine
  GuaranteeRun(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const GuaranteePlan& plan);

  // Returns true once a bound has reached epsilon, or all runs of a median are done.
  bool isDone();
  // Counts the blocks up to the next look at Bernstein's bound, but at most some hundred directions.
  //   In: on_block: is called after each block; may throw; may be empty
  //   Throws: whatever the engine throws, and then the sums stay as they were; whatever on_block throws.
  void step(const std::function<void()>& on_block = {});
  const RunSums& sums() const { return sums_; }
  uint64_t expectedBlocks() const { return is_median_ ? plan_.runs : plan_.expected_blocks; }
  uint64_t mostBlocks() const { return most_blocks_; }
  double bound() const { return guarantee_.bound; }
  // Returns the estimate from the blocks counted so far. It carries no guarantee.
  Estimate estimateSoFar() const;
  // Returns the estimate with the guarantee. Call it once the run is done.
  Estimate estimate() const;

 private:
  void passLook();

  const Ids& ids_;
  GuaranteeOptions options_;
  const GuaranteePlan& plan_;
  bool is_median_;
  uint64_t directions_, most_blocks_;  // directions of a block; blocks of the whole run, at most
  RunSums sums_;
  std::vector<PairCounts> runs_;  // the counts of each run that a median is taken of; else empty
  Guarantee guarantee_;
  // look_ counts the looks taken at Bernstein's bound. The next look takes place after next_look_ blocks.
  uint64_t look_ = 0, next_look_;
  bool is_done_ = false;
};

}  // namespace viewpeel
