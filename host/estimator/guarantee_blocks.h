// The plan and the run of a guarantee share these functions, which count blocks of directions and bound the errors.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

// From one look at Bernstein's bound to the next, the number of blocks grows by this factor.
constexpr double kEpochGrowth = 1.15;

// Returns the counts of `blocks` blocks, one by one, from block number `first` on. Each has `directions` directions.
//   Cost: that of one engine call for all blocks together.
std::vector<PairCounts> countBlocks(Engine& engine, const GuaranteeOptions& options, uint64_t directions,
                                    uint64_t first, uint64_t blocks);

// Returns sums that hold no block yet, and the plan's visibilities.
RunSums makeGuaranteeSums(const Scene& scene, const Ids& ids, const GuaranteePlan& plan, uint64_t directions);

// Returns a function that predicts the bound on all errors together after a number of blocks, with failure probability
// p. The prediction assumes that further blocks vary as the blocks of `sums` do. The plan must outlive the function.
std::function<double(double blocks, double p)> boundFor(const RunSums& sums, const Ids& ids, const GuaranteePlan& plan,
                                                        uint32_t block_directions);

}  // namespace viewpeel
