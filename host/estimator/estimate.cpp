#include "estimator/estimate.h"

#include <algorithm>
#include <cmath>

#include "sums/add_pairs.h"

namespace viewpeel {

FormFactors keepSeen(FormFactors all) {
  Ids ids = all.ids();
  std::vector<Measured> row_sums = all.rowSums();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  std::erase_if(entries, [](const FormFactors::Entry& entry) { return !(entry.exchange_area.value > 0); });
  return {std::move(ids), std::move(entries), std::move(row_sums)};
}

Estimate makeEstimate(const RunSums& sums, double relative_floor, const ExchangeRow& row) {
  return makeEstimate(sums, relative_floor, sums.formFactors(row));
}

Estimate makeEstimate(const RunSums& sums, double relative_floor, FormFactors all) {
  Estimate estimate{FormFactors({}, {}, {}),   keepSeen(sums.betweenSurfaces()),
                    sums.replicateCount(),     sums.directions,
                    largestStandardError(all), largestRelativeError(all, relative_floor)};
  const std::vector<double> areas = all.ids().areas;
  const std::vector<VisibilitySums::PairSum> no_sums;
  const std::vector<DirectedPair> no_pairs;
  const bool by_face = sums.prior_sums && sums.prior_sums->by() == By::polygon;
  const auto& counted = by_face ? sums.prior_sums->byFace().pairs() : no_sums;
  const auto& directed = by_face ? sums.prior_sums->prior().directed : no_pairs;
  auto at = counted.begin();
  auto next_directed = directed.begin();
  const auto isAmong = [](const auto& pairs, auto& next, const FormFactors::Entry& entry) {
    while (next != pairs.end() && keyOf(*next) < keyOf(entry)) ++next;
    return next != pairs.end() && keyOf(*next) == keyOf(entry);
  };
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j >= kEnvironment) continue;
    const bool is_unmet =
        by_face && entry.i != entry.j && !isAmong(counted, at, entry) && !isAmong(directed, next_directed, entry);
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

}  // namespace viewpeel
