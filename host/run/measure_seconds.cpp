// measureSeconds() predicts the time of a run from trials of its parts.
#include <algorithm>
#include <cmath>

#include "directions/replicates.h"
#include "estimator/promise_cost.h"
#include "run/run_state.h"
#include "stopwatch.h"
#include <viewpeel/compute.h>

namespace viewpeel {
namespace {

constexpr double kTrialSeconds = 0.5;  // least time of a trial of directions
// After its planned replicates an estimate by pair lines draws about this many more, for entries whose errors turned
// out larger than planned (scenes of docs/speed.md).
constexpr double kFurtherReplicates = 3;

}  // namespace

// Times three replicates: the lines of the first alone, and of the others at once where a run draws them so. What
// replicates have in common, such as making a pair ready, then takes its time once. The last one also has the
// comparison with the goal. A run compares after each replicate from the planned number on, and once more for the
// result.
double FormFactorRun::State::measureLineSeconds() {
  EstimateOptions options = estimateOptions();
  const double replicates = options.replicates;
  options.replicates = 3;
  options.seconds = INFINITY;  // with a time limit a run begins with one replicate alone
  options.first_replicate = kTrialReplicates.first;
  options.resumed = nullptr;
  LineRun trial(*plan->engine, setup.scene(), setup.faceIds(), *pair_lines, line_pairs, line_mixture.least_form_factor,
                options);
  const auto secondsOfStep = [&] {
    const auto begun = Clock::now();
    trial.step();
    return secondsSince(begun);
  };
  const double alone = secondsOfStep(), next = secondsOfStep();
  const bool are_ahead = trial.hasDrawnAhead();
  const double last = secondsOfStep();
  if (!are_ahead) return replicates * next * kLinesOverPlan + (kFurtherReplicates + 2) * std::max(0.0, last - next);
  // Rays are cast ahead, but common directions are counted in each replicate, which takes longer than the comparison.
  const double of_directions = plan->directions > 0 && !line_mixture.hasRays() ? last : 0,
               of_lines = std::max(0.0, next - alone), in_common = std::max(0.0, alone - of_lines - of_directions),
               batches = std::ceil(replicates / trial.mostAhead());
  return (batches * in_common + replicates * of_lines) * kLinesOverPlan + replicates * of_directions +
         (kFurtherReplicates + 2) * last;
}

// Times a few directions, and then as many as kTrialSeconds have room for. Returns the seconds of a direction.
double FormFactorRun::State::measureDirectionSeconds() {
  const EstimateOptions& estimate = setup.estimate();
  const auto directionsOf = [&](uint32_t count) {
    return estimate.drawn_directions ? estimate.drawn_directions(count, kPlanReplicates.first).directions
                                     : sampleDirections(estimate.sampler, count, estimate.seed, kPlanReplicates.first);
  };
  double each = 0;
  uint32_t count = std::min(4u, plan->directions);
  for (uint32_t turn = 0; turn < 2; ++turn) {
    if (turn == 0) engine().count(directionsOf(count));  // compiles and tunes kernels before the clock starts
    const auto trial = Clock::now();
    engine().count(directionsOf(count));
    each = std::max(secondsSince(trial), 1e-9) / count;
    count = std::clamp(static_cast<uint32_t>(kTrialSeconds / each), 1u, plan->directions);
  }
  return each;
}

double FormFactorRun::measureSeconds() {
  const PlanSummary& summary = makePlan();
  if (summary.guarantee) return summary.guarantee->expected_seconds;
  if (summary.line_guarantee) {
    const uint32_t directions = state_->common_counts ? 0 : state_->plan->directions * kFewReplicates;
    return summary.line_guarantee->expected_seconds + (directions ? directions * state_->measureDirectionSeconds() : 0);
  }
  if (summary.pilot_seconds > 0) return summary.seconds;
  if (state_->pair_lines) return state_->measureLineSeconds();
  return state_->measureDirectionSeconds() * state_->plan->directions * state_->setup.estimate().replicates;
}

}  // namespace viewpeel
