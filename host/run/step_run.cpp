// This file runs the plan: it finds the prior, begins the planned way of counting, takes its steps and reads its
// result.

#include <algorithm>
#include <cmath>
#include <utility>

#include <viewpeel/error.h>
#include "run/rules.h"
#include "run/run_state.h"

namespace viewpeel {

void FormFactorRun::State::findPrior() {
  if (!setup.usesUnoccluded() || setup.guarantee() || resumed || prior_summary) return;
  enter(Progress::Phase::unoccluded);
  EstimateOptions pilot = setup.estimate();
  pilot.directions = plan->directions;
  pilot.pairs = &pairs;
  found_prior = viewpeel::findPrior(engine(), exchanges, setup.scene(), setup.faceIds(), plan->groups, pilot,
                                    choosePriorPilot(pilot));
  prior_summary = summarise(found_prior);
}

EstimateOptions FormFactorRun::State::estimateOptions() {
  EstimateOptions options = setup.estimate();
  options.directions = plan->directions;
  options.rays = rays;
  options.resumed = resumed ? &resumed->sums : nullptr;
  options.pairs = &pairs;
  if (setup.usesUnoccluded()) {
    options.prior = &found_prior.prior;
    options.exchanges = &exchanges;
  }
  if (options.seconds) options.seconds = std::max(*options.seconds - secondsSince(*start), 1e-3);
  return options;
}

// Counts along common directions, for environment and leak of a guarantee.
//   Out: by replicate; counts of pairs are kept only where some pairs get no lines
std::vector<PairCounts> FormFactorRun::State::countCommonDirections() const {
  std::vector<PairCounts> all;
  for (uint64_t replicate = 0; plan->directions && replicate < kFewReplicates; ++replicate) {
    all.push_back(plan->engine->count(
        sampleDirections(setup.estimate().sampler, plan->directions, setup.request().seed, replicate)));
    if (setup.leastFormFactor() > 0) continue;
    std::erase_if(all.back(), [](const PairCount& count) { return count.j < kEnvironment; });
  }
  return all;
}

void FormFactorRun::State::beginLineGuarantee() {
  progress.expected_blocks = progress.most_blocks = line_guarantee->mostLooks();
  const std::vector<PairCounts> counts = common_counts ? std::move(*common_counts) : countCommonDirections();
  common_sums.emplace(makeRunSums(setup.scene(), setup.faceIds()));
  if (plan->directions) common_sums->measure_area = commonCountArea();
  for (uint64_t replicate = 0; replicate < counts.size(); ++replicate)
    common_sums->add(replicate, counts[replicate], plan->directions);
}

// Returns measure_area of ReplicateSums for a replicate of common directions: the area that one count stands for, over
// the number of directions, input units squared.
double FormFactorRun::State::commonCountArea() const {
  return plan->engine->unitArea() * setup.scene().scale * setup.scene().scale / double(plan->directions);
}

template <class Run>
void FormFactorRun::State::beginEstimate(const Run& run) {
  progress.replicates = progress.resumed = replicateCount();
  progress.largest_standard_error = run.largestStandardError();
  is_done = run.isDone();
}

void FormFactorRun::State::begin() {
  progress.phase = Progress::Phase::counting;
  progress.directions = 0;
  if (line_guarantee) return beginLineGuarantee();
  if (guarantee) {
    GuaranteeOptions options = setup.guaranteeOptions();
    options.resumed = resumed ? &resumed->sums : nullptr;
    guarantee_run.emplace(setup.scene(), setup.ids(), options, *guarantee);
    progress.replicates = progress.resumed = replicateCount();
    progress.expected_blocks = guarantee_run->expectedBlocks();
    progress.most_blocks = guarantee_run->mostBlocks();
    is_done = guarantee_run->isDone();
    return;
  }
  progress.directions_of_replicate = plan->directions;
  if (pair_lines) {
    line_run.emplace(*plan->engine, setup.scene(), setup.faceIds(), *pair_lines, std::move(line_pairs),
                     line_mixture.least_form_factor, estimateOptions());
    return beginEstimate(*line_run);
  }
  EstimateOptions options = estimateOptions();
  if (!setup.isExact())
    options.line_steps =
        meanStepsOfLines(setup.scene(), setup.countedIds(), plan->groups, plan->engine->unitArea(), setup.sampling());
  estimate_run.emplace(*plan->engine, setup.scene(), setup.countedIds(), std::move(options));
  beginEstimate(*estimate_run);
}

void FormFactorRun::State::step() {
  const auto report = [&] {
    progress.replicates = replicateCount();
    progress.directions = 0;
    reportProgress();
    stopIfRequested();
  };
  if (line_guarantee) {
    try {
      line_guarantee->step();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::limit || !setup.hasPromise() || setup.request().promise) throw;
      return breakPromise(error.what());
    }
    is_done = line_guarantee->isDone();
    report();
    return;
  }
  if (guarantee_run) {
    guarantee_run->step(report);
    is_done = guarantee_run->isDone();
    return;
  }
  const auto stepOf = [&](auto& run) {
    run.step();
    is_done = run.isDone();
    progress.largest_standard_error = run.largestStandardError();
    report();
  };
  if (line_run) stepOf(*line_run);
  else stepOf(*estimate_run);
}

// Returns the estimate of a run that was stopped before it counted anything.
Estimate FormFactorRun::State::estimateOfNothing() const {
  return {FormFactors(setup.ids(), {}, std::vector<Measured>(setup.ids().count())),
          FormFactors({}, {}, {}),
          0,
          0,
          INFINITY,
          INFINITY};
}

bool FormFactorRun::State::isGoalReached() const {
  if (is_interrupted || !isBegun()) return false;
  if (line_guarantee || guarantee_run) return is_done;
  if (std::holds_alternative<Seconds>(setup.request().goal)) return true;
  const Amount amount = amountOf(setup.request());
  return replicateCount() >= amount.replicates &&
         (amount.is_exact || (line_run ? line_run->isReached() : estimate_run->isReached()));
}

Result FormFactorRun::State::resultOf(Estimate estimate) const {
  Result result{std::move(estimate)};
  result.interrupted = is_interrupted;
  result.goal_reached = isGoalReached();
  result.closure = measureClosure(result.form_factors);
  result.environment_share = shareOf(result.form_factors, kEnvironment);
  result.leak_share = shareOf(result.form_factors, kLeak);
  result.plan = summary;
  result.seconds = start ? secondsSince(*start) : 0;
  if (!setup.request().balance) return result;
  try {
    result.balanced = balanceRows(result.form_factors);
  } catch (const Error& error) {
    result.balance_refusal = error;
  }
  return result;
}

}  // namespace viewpeel
