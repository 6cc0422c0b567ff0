#include "estimator/estimate.h"

#include <chrono>

#include "error.h"

namespace viewpeel {

Estimate estimateFormFactors(Engine& engine, const Scene& scene, const Ids& ids, const EstimateOptions& options) {
  if (options.directions < 1) throw Error(ErrorCode::bad_usage, "0 directions per replicate; ask for at least 1");
  if (options.replicates < 2) throw Error(ErrorCode::bad_usage, "a standard error needs at least 2 replicates");
  for (const std::optional<double>& goal : {options.tolerance, options.relative, options.seconds})
    if (goal && !(*goal > 0)) throw Error(ErrorCode::bad_usage, "a tolerance, relative error or time to reach must be above 0");

  const auto directionsOf = [&](uint64_t replicate) -> AskedDirections {
    if (options.asked_directions) return options.asked_directions(options.directions, replicate);
    return {sampleDirections(options.sampler, options.directions, options.seed, replicate), {}, 1};
  };
  const double count_area = engine.unitArea() * scene.scale * scene.scale / options.directions;
  RunSums sums = makeRunSums(scene, ids);
  double largest_error = 0, largest_relative_error = 0;
  const auto measureErrors = [&] {
    largest_error = sums.by_id.largestStandardError(sums.measure_area);
    largest_relative_error = sums.by_id.largestRelativeError(sums.measure_area, options.relative_floor);
  };
  if (options.resumed) {
    sums.add(*options.resumed);
    measureErrors();
  }
  const uint64_t resumed_count = sums.replicateCount();
  const auto start = std::chrono::steady_clock::now();
  const auto isDone = [&] {
    const uint64_t done = sums.replicateCount();
    const auto done_here = double(done - resumed_count);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.seconds && done >= 2 && done_here > 0 && seconds * (done_here + 1) / done_here > *options.seconds) return true;
    return done >= options.replicates && (!options.tolerance || largest_error <= *options.tolerance) &&
           (!options.relative || largest_relative_error <= *options.relative) && !(options.seconds && !options.tolerance && !options.relative);
  };
  bool interrupted = false;
  try {
    while (!isDone()) {
      const uint64_t replicate = options.first_replicate + sums.replicateCount();
      AskedDirections asked = directionsOf(replicate);
      for (size_t k = 0; k < asked.weights.size(); ++k) asked.directions[k].weight = asked.weights[k];
      if (sums.replicateCount() == 0) sums.measure_area = count_area * asked.weight_unit;
      sums.add(replicate, asked.directions.empty() ? PairCounts{} : engine.count(asked.directions), options.directions);
      measureErrors();
      if (options.on_sums) options.on_sums(sums, false);
      if (options.on_so_far) options.on_so_far([&] { return makeEstimate(sums, options.relative_floor); });
      if (options.on_replicate) options.on_replicate({sums.replicateCount(), largest_error});
    }
  } catch (const Interrupted&) {
    interrupted = true;
  } catch (...) {
    if (options.on_sums) options.on_sums(sums, true);
    throw;
  }
  if (options.on_sums) options.on_sums(sums, true);
  Estimate estimate = makeEstimate(sums, options.relative_floor);
  estimate.interrupted = interrupted;
  return estimate;
}

Estimate makeEstimate(const RunSums& sums, double relative_floor) {
  return {sums.by_id.formFactors(sums.measure_area),
          sums.by_surface.formFactors(sums.measure_area),
          sums.replicateCount(),
          sums.directions,
          sums.by_id.largestStandardError(sums.measure_area),
          sums.by_id.largestRelativeError(sums.measure_area, relative_floor)};
}

}  // namespace viewpeel
