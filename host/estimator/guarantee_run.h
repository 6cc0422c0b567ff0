// A GuaranteeRun is guarantee mode in steps: each counts some blocks, until one of the bounds is epsilon.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

class GuaranteeRun {
 public:
  // Starts the run, from the sums of an earlier one where options have them.
  //   In: ids, plan: referred to, with the plan's engine
  GuaranteeRun(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const GuaranteePlan& plan);

  // Returns true where a bound is epsilon, or all runs of a median are done.
  bool isDone();
  // Counts as many blocks at once as there are until the next look at Bernstein's bound, up to some hundred directions.
  //   In: on_block: called after each block; may throw, may be empty
  //   Throws: what the engine throws, the sums are then as before; what on_block throws.
  void step(const std::function<void()>& on_block = {});
  const RunSums& sums() const { return sums_; }
  uint64_t expectedBlocks() const { return is_median_ ? plan_.runs : plan_.expected_blocks; }
  uint64_t mostBlocks() const { return most_blocks_; }
  double bound() const { return guarantee_.bound; }
  // Returns the estimate from the blocks up to now, which is no guarantee.
  Estimate estimateSoFar() const;
  // Returns the estimate with the guarantee. Call it once the run is done.
  Estimate estimate() const;

 private:
  void passLook();

  const Ids& ids_;
  GuaranteeOptions options_;
  const GuaranteePlan& plan_;
  bool is_median_;
  uint64_t directions_, most_blocks_;  // of a block
  RunSums sums_;
  std::vector<PairCounts> runs_;  // of the median
  Guarantee guarantee_;
  // Bernstein's bound is looked at after set numbers of blocks.
  uint64_t look_ = 0, next_look_;
  bool is_done_ = false;
};

}  // namespace viewpeel
