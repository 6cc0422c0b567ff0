#include "estimator/estimate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "error.h"
#include "estimator/directed_pairs.h"
#include "estimator/face_exchanges.h"
#include "sums/add_pairs.h"

namespace viewpeel {

FormFactors keepSeen(FormFactors all) {
  Ids ids = all.ids();
  std::vector<Measured> row_sums = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  std::erase_if(entries, [](const FormFactors::Entry& entry) { return !(entry.exchange_area.value > 0); });
  return {std::move(ids), std::move(entries), std::move(row_sums)};
}

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
  if (options.known && !options.resumed) sums.visible.emplace(sums.by_id.ids(), sums.by_surface.ids(), options.by, *options.known);
  std::vector<DirectedPair> directed;
  if (const RunSums& begun = options.resumed ? *options.resumed : sums; begun.visible) directed = begun.visible->known().directed;
  if (!directed.empty() && !options.pairs)
    throw Error(ErrorCode::bad_usage, "some pairs have directions of their own, and nothing to count them with; give EstimateOptions::pairs");
  if (!directed.empty()) options.pairs->prepare(directed);
  ExchangeRow row;
  if (const RunSums& begun = options.resumed ? *options.resumed : sums; begun.visible && options.exchanges && !begun.visible->known().has_all_pairs) row = options.exchanges->rows();
  double largest_error = INFINITY, largest_relative_error = INFINITY;
  const auto isReached = [&] { return (!options.tolerance || largest_error <= *options.tolerance) && (!options.relative || largest_relative_error <= *options.relative); };
  std::optional<FormFactors> found;  // where the goal is reached
  const auto measureErrors = [&] {
    found.reset();
    if (!(options.tolerance || options.relative) || sums.replicateCount() < options.replicates) return;  // nobody asks
    if (sums.visible) {
      const auto measure = [&](const FormFactors& so_far) {
        largest_error = largestStandardError(so_far);
        largest_relative_error = largestRelativeError(so_far, options.relative_floor);
        return isReached();
      };
      // Rows of all pairs take seconds, and mostly it is one of those known for which there have to be more replicates.
      if (row && !measure(sums.knownFormFactors())) return;
      FormFactors all = sums.formFactors(row);
      if (measure(all)) found = std::move(all);
      return;
    }
    if (options.relative) largest_relative_error = sums.by_id.largestRelativeError(sums.measure_area, options.relative_floor, sums.countArea());
    largest_error = sums.by_id.largestStandardError(sums.measure_area, sums.countArea());
  };
  if (options.resumed) {
    sums.add(*options.resumed);
    if (options.exchanges) options.exchanges->learn(sums);
    measureErrors();
  }
  const uint64_t resumed_count = sums.replicateCount();
  const auto start = std::chrono::steady_clock::now();
  const auto isDone = [&] {
    const uint64_t done = sums.replicateCount();
    const auto done_here = double(done - resumed_count);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options.seconds && done >= 2 && done_here > 0 && seconds * (done_here + 1) / done_here > *options.seconds) return true;
    return done >= options.replicates && isReached() && !(options.seconds && !options.tolerance && !options.relative);
  };
  bool interrupted = false;
  try {
    while (!isDone()) {
      const uint64_t replicate = options.first_replicate + sums.replicateCount();
      AskedDirections asked = directionsOf(replicate);
      for (size_t k = 0; k < asked.weights.size(); ++k) asked.directions[k].weight = asked.weights[k];
      if (sums.replicateCount() == 0) sums.measure_area = count_area * asked.weight_unit;
      const PairCounts of_directed = directed.empty() ? PairCounts{} : options.pairs->count(directed, replicate);
      sums.add(replicate, asked.directions.empty() ? PairCounts{} : engine.count(asked.directions), options.directions, of_directed);
      if (options.exchanges) options.exchanges->learn(sums);
      measureErrors();
      if (options.on_sums) options.on_sums(sums, false);
      if (options.on_so_far) options.on_so_far([&] { return makeEstimate(sums, options.relative_floor, row); });
      if (options.on_replicate) options.on_replicate({sums.replicateCount(), largest_error});
    }
  } catch (const Interrupted&) {
    interrupted = true;
  } catch (...) {
    if (options.on_sums) options.on_sums(sums, true);
    throw;
  }
  if (options.on_sums) options.on_sums(sums, true);
  Estimate estimate = found ? makeEstimate(sums, options.relative_floor, std::move(*found)) : makeEstimate(sums, options.relative_floor, row);
  estimate.interrupted = interrupted;
  return estimate;
}

Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row) { return makeEstimate(sums, relative_floor, sums.formFactors(row)); }

Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all) {
  Estimate estimate{FormFactors({}, {}, {}), keepSeen(sums.betweenSurfaces()), sums.replicateCount(), sums.directions, largestStandardError(all), largestRelativeError(all, relative_floor)};
  const std::vector<double> areas = all.ids().areas;
  const std::vector<ShareSums::PairSum> no_sums;
  const std::vector<DirectedPair> no_pairs;
  const bool by_face = sums.visible && sums.visible->by() == By::polygon;
  const auto& told = by_face ? sums.visible->byFace().pairs() : no_sums;
  const auto& directed = by_face ? sums.visible->known().directed : no_pairs;
  auto at = told.begin();
  auto own = directed.begin();
  const auto isAmong = [](const auto& pairs, auto& next, const FormFactors::Entry& entry) {
    while (next != pairs.end() && keyOf(*next) < keyOf(entry)) ++next;
    return next != pairs.end() && keyOf(*next) == keyOf(entry);
  };
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j >= kEnvironment) continue;
    const bool is_unmet = by_face && entry.i != entry.j && !isAmong(told, at, entry) && !isAmong(directed, own, entry);
    if (!is_unmet && entry.exchange_area.value > 0) continue;
    const double error = entry.exchange_area.standard_error / std::min(areas[entry.i], areas[entry.j]);
    uint64_t& pairs = is_unmet ? estimate.unmet_pairs : estimate.unseen_pairs;
    double& largest = is_unmet ? estimate.largest_unmet_error : estimate.largest_unseen_error;
    ++pairs;
    largest = std::max(largest, error);
  }
  estimate.form_factors = keepSeen(std::move(all));
  if (sums.visible) {
    const std::vector<DirectedPair>& directed_pairs = sums.visible->known().directed;
    estimate.directed_pairs = directed_pairs.size();
    for (const DirectedPair& pair : directed_pairs) estimate.directed_directions += pair.directions * sums.replicateCount();
  }
  // With all closed forms what is no entry sees nothing of the other, whatever is between them.
  const auto isSampledAlone = [](const KnownPair& pair) { return pair.j < kEnvironment && std::isinf(pair.exchange); };
  const bool knows_all = sums.visible && sums.visible->known().has_all_pairs && std::none_of(sums.visible->known().pairs.begin(), sums.visible->known().pairs.end(), isSampledAlone);
  if (!knows_all && !std::isinf(sums.countArea())) estimate.unmet_bound = unmetBound(*std::min_element(areas.begin(), areas.end()), sums.countArea(), double(sums.directions));
  return estimate;
}

}  // namespace viewpeel
