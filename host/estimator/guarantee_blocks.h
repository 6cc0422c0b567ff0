// Blocks of a guarantee: how they are counted, and what their sums bound. Planning and running share it.
#pragma once
#include <functional>
#include <vector>

#include "estimator/guarantee.h"

namespace viewpeel {

constexpr double kEpochGrowth = 1.15;  // of the blocks from one look at Bernstein's bound to the next

// What the engine counts in each of several blocks, the first of them `first`.    Cost: as one call of the engine for
// all.
std::vector<PairCounts> countBlocks(Engine& engine, const GuaranteeOptions& options, uint64_t directions,
                                    uint64_t first, uint64_t blocks);

// Sums of no blocks, with the plan's visibilities.
RunSums makeGuaranteeSums(const Scene& scene, const Ids& ids, const GuaranteePlan& plan, uint64_t directions);

// A bound on all errors at once, that holds with probability 1 - p after so many blocks, if blocks go on to vary as
// those of `sums` do. It refers to the plan.
std::function<double(double blocks, double p)> boundFor(const RunSums& sums, const Ids& ids, const GuaranteePlan& plan,
                                                        uint32_t block_directions);

}  // namespace viewpeel
