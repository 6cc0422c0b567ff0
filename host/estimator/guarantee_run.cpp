#include "estimator/guarantee_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/guarantee_blocks.h"

namespace viewpeel {
namespace {

// One engine call counts blocks with up to this number of directions in all.
constexpr uint64_t kDirectionsOfCall = 512;

std::vector<PairCounts> mergeIdsOfAll(const std::vector<PairCounts>& runs, const std::vector<uint32_t>& id_map) {
  std::vector<PairCounts> merged;
  for (const PairCounts& run : runs) merged.push_back(mergeIds(run, id_map));
  return merged;
}

// Replaces the mean of every form factor by its median over the runs. Standard errors assume normal errors: the
// variance of a median is pi / 2 times the variance of a mean. Row sums stay sums of means.
FormFactors medianOf(const std::vector<PairCounts>& runs, const FormFactors& means, double measure_area) {
  std::vector<FormFactors::Entry> entries = means.entries();
  std::vector<size_t> at(runs.size(), 0);
  std::vector<uint64_t> counts(runs.size());
  for (FormFactors::Entry& entry : entries) {
    for (size_t r = 0; r < runs.size(); ++r) {
      const bool is_there = at[r] < runs[r].size() && runs[r][at[r]].i == entry.i && runs[r][at[r]].j == entry.j;
      counts[r] = is_there ? runs[r][at[r]++].count : 0;
    }
    std::nth_element(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2), counts.end());
    entry.exchange_area.value = (entry.i == entry.j ? 4 : 2) * measure_area * double(counts[counts.size() / 2]);
    entry.exchange_area.standard_error *= std::sqrt(std::numbers::pi / 2);
  }
  return {means.ids(), std::move(entries), means.rowSums()};
}

// Gives every form factor an interval. `bound` is the half-width for the form factor from the pair's smaller id; the
// form factor from the larger id has a smaller half-width, by the ratio of areas.
FormFactors withIntervals(FormFactors all, double bound) {
  const Ids ids = all.ids();
  std::vector<Measured> row_sums = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : entries) {
    const double value = entry.exchange_area.value, off = bound * ids.smallerArea(entry.i, entry.j);
    intervals.push_back({std::max(0.0, value - off), value + off});
  }
  return {ids, std::move(entries), std::move(row_sums), std::move(intervals), bound};
}

}  // namespace

GuaranteeRun::GuaranteeRun(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                           const GuaranteePlan& plan)
    : ids_(ids),
      options_(options),
      plan_(plan),
      is_median_(options.statistic == Statistic::median),
      directions_(is_median_ ? plan.run_directions : plan.block_directions),
      most_blocks_(is_median_ ? plan.runs : plan.most_blocks),
      sums_(makeGuaranteeSums(scene, ids, plan, directions_)),
      guarantee_{options.epsilon, options.delta, INFINITY, is_median_ ? GuaranteedBy::median : GuaranteedBy::hoeffding},
      next_look_(std::max<uint64_t>(2, plan.least_blocks)) {
  if (options_.resumed) {
    // The visibilities of the run that this one continues replace the plan's.
    sums_.prior_sums.reset();
    sums_.add(*options_.resumed);
  }
  // The stopped run has taken these looks, and none found a bound within epsilon.
  while (next_look_ < sums_.replicateCount()) passLook();
}

void GuaranteeRun::passLook() {
  ++look_;
  next_look_ = static_cast<uint64_t>(std::ceil(double(next_look_) * kEpochGrowth));
}

bool GuaranteeRun::isDone() {
  const uint64_t blocks = sums_.replicateCount();
  if (is_done_ || blocks >= most_blocks_) return is_done_ = true;
  if (is_median_ || blocks != next_look_) return false;
  passLook();
  guarantee_.bound = boundFor(sums_, ids_, plan_, static_cast<uint32_t>(directions_))(
      double(blocks), options_.delta / (2 * double(look_) * double(look_ + 1)));
  if (guarantee_.bound > options_.epsilon) return false;
  guarantee_.by = GuaranteedBy::bernstein;
  return is_done_ = true;
}

void GuaranteeRun::step(const std::function<void()>& on_block) {
  uint64_t block = sums_.replicateCount();
  const uint64_t end = is_median_ ? most_blocks_ : std::min(most_blocks_, next_look_),
                 together = std::max<uint64_t>(kDirectionsOfCall / directions_, 1);
  for (PairCounts& counts : countBlocks(*plan_.engine, options_, directions_, block, std::min(end - block, together))) {
    sums_.add(block++, counts, directions_);
    if (is_median_) runs_.push_back(std::move(counts));
    if (on_block) on_block();
  }
}

Estimate GuaranteeRun::estimateSoFar() const { return makeEstimate(sums_, EstimateOptions{}.relative_floor); }

Estimate GuaranteeRun::estimate() const {
  Estimate estimate = estimateSoFar();
  if (is_median_) {
    estimate.form_factors = medianOf(runs_, estimate.form_factors, sums_.measure_area);
    estimate.between_surfaces =
        medianOf(mergeIdsOfAll(runs_, ids_.surface), estimate.between_surfaces, sums_.measure_area);
  }
  if (sums_.prior_sums)
    estimate.form_factors = keepSeen(sums_.prior_sums->controlledFormFactors(
        sums_.measure_area, sums_.by_id.formFactors(sums_.measure_area, sums_.countArea())));
  estimate.guarantee = guarantee_;
  if (guarantee_.by != GuaranteedBy::bernstein) estimate.guarantee->bound = options_.epsilon;
  estimate.form_factors = withIntervals(std::move(estimate.form_factors), estimate.guarantee->bound);
  return estimate;
}

Estimate guaranteeFormFactors(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                              const GuaranteePlan& plan) {
  GuaranteeRun run(scene, ids, options, plan);
  const auto onBlock = [&] {
    if (options.on_sums) options.on_sums(run.sums(), false);
    if (options.on_block)
      options.on_block({run.sums().replicateCount(), run.expectedBlocks(), run.mostBlocks(), run.bound()});
  };
  try {
    while (!run.isDone()) run.step(onBlock);
  } catch (const Interrupted&) {
    if (options.on_sums) options.on_sums(run.sums(), true);
    Estimate estimate = run.estimateSoFar();  // this estimate has no guarantee
    estimate.interrupted = true;
    return estimate;
  } catch (...) {
    if (options.on_sums) options.on_sums(run.sums(), true);
    throw;
  }
  if (options.on_sums) options.on_sums(run.sums(), true);
  return run.estimate();
}

}  // namespace viewpeel
