// Planning and running a guarantee share these functions: they count blocks and bound the errors of their sums.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

constexpr double kEpochGrowth = 1.15;  // of the blocks from one look at Bernstein's bound to the next

// Returns the counts of each of several blocks, the first of them `first`.    Cost: as one call of the engine for all.
std::vector<PairCounts> countBlocks(Engine& engine, const GuaranteeOptions& options, uint64_t directions,
                                    uint64_t first, uint64_t blocks);

// Makes the sums of no blocks, with the plan's visibilities.
RunSums makeGuaranteeSums(const Scene& scene, const Ids& ids, const GuaranteePlan& plan, uint64_t directions);

// Returns a bound on all errors at once. It holds with probability 1 - p after this number of blocks, if further blocks
// vary as the blocks of `sums` do. It refers to the plan.
std::function<double(double blocks, double p)> boundFor(const RunSums& sums, const Ids& ids, const GuaranteePlan& plan,
                                                        uint32_t block_directions);

}  // namespace viewpeel
