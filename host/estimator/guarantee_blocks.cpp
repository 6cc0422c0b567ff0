#include "estimator/guarantee_blocks.h"

#include <algorithm>

#include "sums/pair_count.h"

namespace viewpeel {
namespace {

constexpr uint64_t kDirectionsInMemory = 1 << 16;  // directions in memory at a time

PairCounts countBlock(Engine& engine, const GuaranteeOptions& options, uint64_t directions, uint64_t block) {
  // Only runs of a median have blocks so large that they need several parts. Their directions are iid.
  const uint64_t parts = (directions + kDirectionsInMemory - 1) / kDirectionsInMemory;
  PairCounts sum;
  for (uint64_t part = 0; part < parts; ++part) {
    const uint64_t count = directions * (part + 1) / parts - directions * part / parts;
    sum = addCounts(sum, engine.count(sampleDirections(options.sampler, static_cast<uint32_t>(count), options.seed,
                                                       block * parts + part)));
  }
  return sum;
}

}  // namespace

std::vector<PairCounts> countBlocks(Engine& engine, const GuaranteeOptions& options, uint64_t directions,
                                    uint64_t first, uint64_t blocks) {
  if (blocks == 1) return {countBlock(engine, options, directions, first)};
  const auto count = static_cast<uint32_t>(directions);
  return engine.countBlocks(sampleReplicates(options.sampler, count, options.seed, first, blocks), count);
}

RunSums makeGuaranteeSums(const Scene& scene, const Ids& ids, const GuaranteePlan& plan, uint64_t directions) {
  RunSums sums = makeRunSums(scene, ids);
  sums.measure_area = plan.engine->unitArea() * scene.scale * scene.scale / double(directions);
  if (plan.visibility_bounds) sums.prior_sums.emplace(sums.by_id.ids(), sums.by_surface.ids(), By::polygon, plan.prior);
  return sums;
}

std::function<double(double blocks, double p)> boundFor(const RunSums& sums, const Ids& ids, const GuaranteePlan& plan,
                                                        uint32_t block_directions) {
  if (plan.visibility_bounds)
    return [&plan, block_directions,
            variances = plan.visibility_bounds->measureVariances(sums.prior_sums->faceControls(), sums.measure_area)](
               double blocks, double p) {
      return plan.visibility_bounds->largestBound(variances, blocks, block_directions, p);
    };
  // Each entry is {variance, range}. The first one stands for every pair that no line hit: variance 0, largest range.
  std::vector<std::pair<double, double>> entries{{0, *std::max_element(plan.ranges.begin(), plan.ranges.end())}};
  sums.by_id.forEachPair(sums.measure_area, [&](uint32_t i, uint32_t j, const Measured& exchange) {
    const uint32_t smaller = j < kEnvironment && ids.areas[j] < ids.areas[i] ? j : i;
    const double error = exchange.standard_error / ids.areas[smaller];
    entries.push_back({error * error * double(sums.replicateCount()), plan.ranges[smaller]});
  });
  return [entries = std::move(entries), bounds = plan.bounds](double blocks, double p) {
    double largest = 0;
    for (const auto& [variance, range] : entries)
      largest = std::max(largest, bernsteinBound(variance, range, blocks, p / bounds));
    return largest;
  };
}

}  // namespace viewpeel
