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
  double measure_area = engine.unitArea() * scene.scale * scene.scale / options.directions;
  Ids surface_ids = makeIds(scene, By::surface, ids.two_sided);
  surface_ids.rows_sum_to_one = ids.rows_sum_to_one;
  if (!ids.asked.empty()) {
    surface_ids.asked.assign(surface_ids.count(), false);
    for (uint32_t k = 0; k < ids.count(); ++k)
      if (ids.asked[k]) surface_ids.asked[ids.surface[k]] = true;
  }
  ReplicateSums sums(ids), surface_sums(surface_ids);
  double largest_error = 0, largest_relative_error = 0;
  const auto start = std::chrono::steady_clock::now();
  const auto isDone = [&] {
    const auto done = double(sums.replicateCount());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.seconds && done >= 2 && seconds * (done + 1) / done > *options.seconds) return true;
    return done >= options.replicates && (!options.tolerance || largest_error <= *options.tolerance) &&
           (!options.relative || largest_relative_error <= *options.relative) && !(options.seconds && !options.tolerance && !options.relative);
  };
  while (!isDone()) {
    AskedDirections asked = directionsOf(sums.replicateCount());
    for (size_t k = 0; k < asked.weights.size(); ++k) asked.directions[k].weight = asked.weights[k];
    if (sums.replicateCount() == 0) measure_area *= asked.weight_unit;
    const PairCounts counts = asked.directions.empty() ? PairCounts{} : engine.count(asked.directions);
    sums.add(counts);
    surface_sums.add(mergeIds(counts, ids.surface));
    largest_error = sums.largestStandardError(measure_area);
    largest_relative_error = sums.largestRelativeError(measure_area, options.relative_floor);
    if (options.on_replicate) options.on_replicate({sums.replicateCount(), largest_error});
  }
  return {sums.formFactors(measure_area), surface_sums.formFactors(measure_area), sums.replicateCount(),
          sums.replicateCount() * options.directions, largest_error, largest_relative_error};
}

}  // namespace viewpeel
