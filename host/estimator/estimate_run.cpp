#include "estimator/estimate_run.h"

#include <cmath>
#include <utility>

#include <viewpeel/error.h>
#include "estimator/directed_pairs.h"
#include "estimator/face_exchanges.h"

namespace viewpeel {
namespace {

void requireSoundOptions(const EstimateOptions& options) {
  if (options.directions < 1) throw Error(ErrorCode::bad_usage, "0 directions per replicate; ask for at least 1");
  if (options.replicates < 2) throw Error(ErrorCode::bad_usage, "a standard error needs at least 2 replicates");
  for (const std::optional<double>& goal : {options.tolerance, options.relative, options.rms, options.seconds})
    if (goal && !(*goal > 0))
      throw Error(ErrorCode::bad_usage,
                  "a tolerance, relative error, root mean square or time to reach must be above 0");
}

RunSums sumsToBeginWith(const Scene& scene, const Ids& ids, const EstimateOptions& options) {
  requireSoundOptions(options);
  RunSums sums = makeRunSums(scene, ids);
  sums.setLineSteps(options.line_steps);
  if (options.prior && !options.resumed)
    sums.prior_sums.emplace(sums.by_id.ids(), sums.by_surface.ids(), options.by, *options.prior);
  return sums;
}

}  // namespace

EstimateRun::EstimateRun(Engine& engine, const Scene& scene, const Ids& ids, EstimateOptions options)
    : engine_(engine),
      options_(std::move(options)),
      count_area_(engine.unitArea() * scene.scale * scene.scale / options_.directions),
      sums_(sumsToBeginWith(scene, ids, options_)) {
  const RunSums& begun = options_.resumed ? *options_.resumed : sums_;
  if (begun.prior_sums) directed_ = begun.prior_sums->prior().directed;
  if (!directed_.empty() && !options_.pairs)
    throw Error(ErrorCode::bad_usage,
                "some pairs have directions of their own, and nothing to count them with; give EstimateOptions::pairs");
  if (!directed_.empty()) options_.pairs->prepare(directed_);
  if (begun.prior_sums && options_.exchanges && !begun.prior_sums->prior().has_all_pairs)
    row_ = options_.exchanges->rows();
  if (options_.resumed) resume();
  start_ = Clock::now();
}

void EstimateRun::resume() {
  sums_.add(*options_.resumed);
  if (options_.exchanges) options_.exchanges->learn(sums_);
  measureErrors();
  resumed_count_ = sums_.replicateCount();
}

bool EstimateRun::isReached() const {
  return (!options_.tolerance || largest_error_ <= *options_.tolerance) &&
         (!options_.relative || largest_relative_error_ <= *options_.relative) &&
         (!options_.rms || rms_error_ <= *options_.rms);
}

bool EstimateRun::measure(const FormFactors& so_far) {
  largest_error_ = viewpeel::largestStandardError(so_far);
  largest_relative_error_ = largestRelativeError(so_far, options_.relative_floor);
  if (options_.rms) rms_error_ = measureStandardErrors(so_far, 0).rms_with_zeros;
  return isReached();
}

void EstimateRun::measureErrors() {
  found_.reset();
  const uint64_t done = sums_.replicateCount();
  if (!options_.hasErrorGoal() || done < options_.replicates || done < next_measured_)
    return;  // without a goal the largest error is not needed
  measureNow();
  // A mean of many variances falls as the number of replicates, so that there is no need to look before.
  if (options_.rms && !isReached() && std::isfinite(rms_error_))
    next_measured_ = static_cast<uint64_t>(std::ceil(double(done) * std::pow(rms_error_ / *options_.rms, 2)));
}

void EstimateRun::measureNow() {
  if (sums_.prior_sums) {
    // Whole rows take seconds. So the pairs of the prior are measured first: most often one of them has the largest
    // error, and shows that more replicates are needed.
    if (row_ && !measure(sums_.priorFormFactors())) return;
    FormFactors all = sums_.formFactors(row_);
    if (measure(all)) found_ = std::move(all);
    return;
  }
  if (options_.rms) rms_error_ = measureStandardErrors(sums_.formFactors(), 0).rms_with_zeros;
  if (options_.relative)
    largest_relative_error_ =
        sums_.by_id.largestRelativeError(sums_.measure_area, options_.relative_floor, sums_.countArea());
  largest_error_ = sums_.by_id.largestStandardError(sums_.measure_area, sums_.countArea());
}

bool EstimateRun::isDone() const {
  const uint64_t done = sums_.replicateCount();
  const auto done_here = double(done - resumed_count_);
  if (options_.seconds && done >= 2 && done_here > 0 &&
      secondsSince(start_) * (done_here + 1) / done_here > *options_.seconds)
    return true;
  if (options_.is_exact) return done >= options_.replicates;
  return done >= options_.replicates && isReached() && !(options_.seconds && !options_.hasErrorGoal());
}

DrawnDirections EstimateRun::directionsOf(uint64_t replicate) const {
  DrawnDirections drawn =
      options_.drawn_directions
          ? options_.drawn_directions(options_.directions, replicate)
          : DrawnDirections{sampleDirections(options_.sampler, options_.directions, options_.seed, replicate), {}, 1};
  for (size_t k = 0; k < drawn.weights.size(); ++k) drawn.directions[k].weight = drawn.weights[k];
  return drawn;
}

void EstimateRun::step() {
  const uint64_t replicate = options_.first_replicate + sums_.replicateCount();
  const DrawnDirections drawn = directionsOf(replicate);
  if (sums_.replicateCount() == 0) sums_.measure_area = count_area_ * drawn.weight_unit;
  const PairCounts of_directed = directed_.empty() ? PairCounts{} : options_.pairs->count(directed_, replicate);
  sums_.add(replicate, drawn.directions.empty() ? PairCounts{} : engine_.count(drawn.directions), options_.directions,
            of_directed);
  if (options_.exchanges) options_.exchanges->learn(sums_);
  measureErrors();
}

Estimate EstimateRun::estimateSoFar() const { return makeEstimate(sums_, options_.relative_floor, row_); }

Estimate EstimateRun::takeEstimate() {
  if (!found_) return estimateSoFar();
  FormFactors found = *std::exchange(found_, std::nullopt);
  return makeEstimate(sums_, options_.relative_floor, std::move(found));
}

Estimate estimateFormFactors(Engine& engine, const Scene& scene, const Ids& ids, const EstimateOptions& options) {
  EstimateRun run(engine, scene, ids, options);
  bool interrupted = false;
  try {
    while (!run.isDone()) {
      run.step();
      if (options.on_sums) options.on_sums(run.sums(), false);
      if (options.on_replicate) options.on_replicate({run.sums().replicateCount(), run.largestStandardError()});
    }
  } catch (const Interrupted&) {
    interrupted = true;
  } catch (...) {
    if (options.on_sums) options.on_sums(run.sums(), true);
    throw;
  }
  if (options.on_sums) options.on_sums(run.sums(), true);
  Estimate estimate = run.takeEstimate();
  estimate.interrupted = interrupted;
  return estimate;
}

}  // namespace viewpeel
