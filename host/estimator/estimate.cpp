#include "estimator/estimate.h"

#include <algorithm>
#include <cmath>

#include "estimator/find_guesses.h"
#include "memory.h"
#include "sums/calibrate_counts.h"
#include "sums/line_form_factors.h"
#include "sums/row_sums.h"

namespace viewpeel {

double EstimateOptions::allowedError(double form_factor) const {
  const double allowed = tolerance.value_or(INFINITY);
  return relative && form_factor >= relative_floor ? std::min(allowed, *relative * form_factor) : allowed;
}

double EstimateOptions::leastAllowedError() const { return allowedError(relative_floor); }

FormFactors keepSeen(FormFactors all) {
  Ids ids = all.ids();
  std::vector<Measured> row_sums = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  std::erase_if(entries, [](const FormFactors::Entry& entry) { return !(entry.exchange_area.value > 0); });
  return {std::move(ids), std::move(entries), std::move(row_sums)};
}

FormFactors withoutBlockers(FormFactors all) {
  Ids ids = all.ids();
  const auto isLeftOut = [&](const FormFactors::Entry& entry) {
    return ids.onlyBlocks(entry.i) || ids.onlyBlocks(entry.j);
  };
  if (ids.only_blocks.empty() || std::ranges::none_of(all.entries(), isLeftOut)) return all;
  std::vector<FormFactors::Entry> entries, left_out;
  std::vector<Interval> intervals;
  std::vector<bool> has_environment(ids.count());
  for (size_t k = 0; k < all.entries().size(); ++k) {
    const FormFactors::Entry& entry = all.entries()[k];
    (isLeftOut(entry) ? left_out : entries).push_back(entry);
    if (all.hasIntervals() && !isLeftOut(entry)) intervals.push_back(all.intervals()[k]);
    if (entry.j == kEnvironment) has_environment[entry.i] = true;
  }
  // An environment is 1 less its row's entries, with blockers among them. Without blockers the sum of the row is 1 less
  // what ends on them, and errs as much as that.
  std::vector<Measured> row_sums = sumRows(entries, ids.areas);
  const std::vector<Measured> on_blockers = sumRows(left_out, ids.areas);
  for (size_t i = 0; i < row_sums.size(); ++i)
    if (has_environment[i]) row_sums[i].standard_error = on_blockers[i].standard_error;
  return {std::move(ids), std::move(entries), std::move(row_sums), std::move(intervals), all.unlistedBound()};
}

namespace {

// Makes counted pairs fit their rows, in a run by polygon in which they have no lines.
FormFactors calibrated(FormFactors all, const RunSums& sums) {
  const bool has_counted = sums.lines && sums.lines->leastFormFactor() > 0;
  if (!has_counted || sums.lines->by() == By::surface || !all.ids().rows_sum_to_one) return all;
  return calibrateCounts(std::move(all), sums.lines->pairs(), kMostOfCounted * sums.lines->leastFormFactor(),
                         sums.by_id.measureRows(sums.measure_area),
                         sums.by_id.exchangesOfRays(sums.measure_area, sums.countArea()));
}

Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all, FormFactors between_surfaces) {
  Estimate estimate{FormFactors({}, {}, {}), std::move(between_surfaces), sums.replicateCount(),
                    sums.directions,         largestStandardError(all),   largestRelativeError(all, relative_floor)};
  const std::vector<double> areas = all.ids().areas;
  const std::vector<std::pair<uint32_t, uint32_t>> guesses = findGuesses(sums, all);
  auto guess = guesses.begin();
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j >= kEnvironment) continue;
    const bool is_unmet = guess != guesses.end() && *guess == std::pair(entry.i, entry.j);
    if (is_unmet) ++guess;
    if (!is_unmet && entry.exchange_area.value > 0) continue;
    const double error = entry.exchange_area.standard_error / std::min(areas[entry.i], areas[entry.j]);
    uint64_t& pairs = is_unmet ? estimate.unmet_pairs : estimate.unseen_pairs;
    double& largest = is_unmet ? estimate.largest_unmet_error : estimate.largest_unseen_error;
    ++pairs;
    largest = std::max(largest, error);
  }
  estimate.form_factors = keepSeen(std::move(all));
  if (sums.prior_sums) {
    const std::vector<DirectedPair>& directed_pairs = sums.prior_sums->prior().directed;
    estimate.directed_pairs = directed_pairs.size();
    for (const DirectedPair& pair : directed_pairs)
      estimate.directed_directions += pair.directions * sums.replicateCount();
  }
  if (sums.lines) {
    for (const LinePair& pair : sums.lines->pairs()) estimate.line_pairs += pair.blocks > 0;
    estimate.lines = sums.lines->lineCount();
    const double least = sums.lines->leastFormFactor();
    if (!(least > 0)) return estimate;  // all pairs that may see each other have lines
    estimate.unmet_bound = least;
    if (sums.by_id.countsRays()) {
      const ReplicateSums& counted = sums.lines->by() == By::polygon ? sums.by_id : sums.by_surface;
      // In further replicates only environment and leak may have had rays.
      const double of_pairs = double(counted.replicatesOf(0, 0)) / double(counted.replicateCount());
      estimate.unmet_bound = std::min(least, counted.unmetBoundOfRays(of_pairs * double(sums.directions)));
    }
    return estimate;
  }
  // Where the prior has the unoccluded form factors of all pairs, a pair without an entry has F0 = 0: its faces would
  // not see each other even without blockers.
  const auto isSampledAlone = [](const PairPrior& pair) { return pair.j < kEnvironment && std::isinf(pair.exchange); };
  const bool lists_all_pairs =
      sums.prior_sums && sums.prior_sums->prior().has_all_pairs &&
      std::none_of(sums.prior_sums->prior().pairs.begin(), sums.prior_sums->prior().pairs.end(), isSampledAlone);
  if (!lists_all_pairs && !std::isinf(sums.countArea()))
    estimate.unmet_bound =
        unmetBound(*std::min_element(areas.begin(), areas.end()), sums.countArea(), double(sums.directions));
  return estimate;
}

}  // namespace

Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row) {
  FormFactors between_surfaces =
      keepSeen(withoutBlockers(sums.betweenSurfaces()));  // before the others, for it takes memory meanwhile
  if (sums.lines && sums.lines->pairs().size() > kLargeList) returnFreedMemory();
  return makeEstimate(sums, relative_floor, withoutBlockers(calibrated(sums.formFactors(row), sums)),
                      std::move(between_surfaces));
}

Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all) {
  return makeEstimate(sums, relative_floor, std::move(all), keepSeen(sums.betweenSurfaces()));
}

}  // namespace viewpeel
