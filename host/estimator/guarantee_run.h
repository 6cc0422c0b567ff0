// Guarantee mode in steps: some blocks each, until one of its bounds is epsilon.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

class GuaranteeRun {
 public:
  //   In: ids, plan: referred to, with the plan's engine
  GuaranteeRun(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const GuaranteePlan& plan);

  // A bound is epsilon, or all runs of a median are done.
  bool isDone();
  // As many blocks at once as there are until the next look at Bernstein's bound, up to some hundred directions.
  //   In: on_block: called after each of them; may throw, may be empty
  //   Throws: what the engine throws, the sums are then as before; what on_block throws.
  void step(const std::function<void()>& on_block = {});
  const RunSums& sums() const { return sums_; }
  uint64_t expectedBlocks() const { return is_median_ ? plan_.runs : plan_.expected_blocks; }
  uint64_t mostBlocks() const { return most_blocks_; }
  double bound() const { return guarantee_.bound; }
  // What the blocks so far come to: an estimate, and no guarantee.
  Estimate estimateSoFar() const;
  // With the guarantee. Once it is done.
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
  // The looks at Bernstein's bound are after set numbers of blocks.
  uint64_t look_ = 0, next_look_;
  bool is_done_ = false;
};

}  // namespace viewpeel
