// This file makes form factors and intervals from the lines of a guarantee, and bounds the sums of rows.
#include "estimator/line_guarantee.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/estimate.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "sums/pair_walk.h"

namespace viewpeel {

std::vector<LineGuarantee::Row> LineGuarantee::sumRows() const {
  std::vector<Row> rows(ids_.count());
  const auto addTo = [&](uint32_t id, const Entry& entry) {
    Row& row = rows[id];
    row.lower += entry.interval.lower, row.upper += entry.interval.upper;
    row.first += entry.clear + entry.first_facing, row.open += entry.first_open, row.squares += entry.first_variance;
    row.rounding += entry.rounding();
  };
  for (const Entry& entry : entries_) {
    addTo(entry.i, entry);
    if (entry.j < kEnvironment && entry.j != entry.i) addTo(entry.j, entry);
  }
  return rows;
}

// Throws where too much of a row is left open after the first looks, for then further lines cannot bring the bound on
// its sum to epsilon.
void LineGuarantee::requireRows() const {
  const std::vector<Row> rows = sumRows();
  for (uint32_t id = 0; id < ids_.count(); ++id) {
    if (!ids_.isRequested(id) || !ids_.counts_environment) continue;
    const double off =
        (std::sqrt(log_row_ * rows[id].squares / 2) + rows[id].rounding + rows[id].open) / ids_.areas[id];
    if (off > options_.epsilon)
      throw Error(
          ErrorCode::limit,
          fmt::format("{} has slivers beside it in so many pairs that its form factor to the environment is bounded "
                      "only to {:.2e}; ask for a larger --epsilon, or leave out --rows",
                      ids_.names[id], off));
  }
}

// Returns the interval of each entry, as exchange areas. An environment has two bounds, which are intersected: eq. (55)
// from the first lines of its row, and the sum of the intervals of the row's other entries.
std::vector<Interval> LineGuarantee::findIntervals(const FormFactors& form_factors) const {
  const std::vector<Row> rows = sumRows();
  const auto leftBy = [&](uint32_t id) {
    const Row& row = rows[id];
    const double area = ids_.areas[id];
    Interval left{std::max(0.0, area - row.upper), std::max(0.0, area - row.lower)};
    if (options_.least_form_factor > 0) left.lower = 0;  // pairs left out may take all of the rest
    if (options_.delta == 0 || options_.least_form_factor > 0) return left;
    const double bound = std::sqrt(log_row_ * row.squares / 2) + row.rounding;
    left.lower = std::max(left.lower, std::min(left.upper, area - row.first - row.open - bound));
    left.upper = std::max(left.lower, std::min(left.upper, area - row.first + bound));
    return left;
  };
  std::vector<Interval> intervals;
  PairWalk walk(entries_);
  for (const FormFactors::Entry& wanted : form_factors.entries()) {
    if (wanted.j == kEnvironment) {
      intervals.push_back(leftBy(wanted.i));
      continue;
    }
    const Entry* const entry = walk.find(wanted);
    if (!entry) {  // only common directions have counted it
      const double most = wanted.j == kLeak ? INFINITY : options_.epsilon * ids_.smallerArea(wanted.i, wanted.j);
      intervals.push_back({0, std::min(most, leftBy(wanted.i).upper)});
      continue;
    }
    Interval interval = entry->interval;
    if (ids_.counts_environment)
      for (const uint32_t id : {entry->i, entry->j})
        if (id < kEnvironment && ids_.isRequested(id))
          interval.upper =
              std::min(interval.upper, std::max(interval.lower, ids_.areas[id] - rows[id].lower + interval.lower));
    intervals.push_back(interval);
  }
  return intervals;
}

// Adds an environment to each row in which no line left the scene, if other rows have one. So every row has an interval
// for its environment.
FormFactors LineGuarantee::withEveryEnvironment(FormFactors all) const {
  std::vector<char> has_environment(ids_.count(), false);
  bool is_open = false;
  for (const FormFactors::Entry& entry : all.entries())
    if (entry.j == kEnvironment) has_environment[entry.i] = is_open = true;
  if (!is_open) return all;
  std::vector<Measured> row_sums = all.rowSums();
  const Ids ids = all.ids();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (has_environment[id] || !ids.isRequested(id)) continue;
    const double left = std::max(0.0, 1 - row_sums[id].value) * ids.areas[id];
    entries.push_back({id, kEnvironment, {left, row_sums[id].standard_error * ids.areas[id]}});
    row_sums[id].value = std::max(row_sums[id].value, 1.0);
  }
  std::ranges::sort(entries, {}, keyOf<FormFactors::Entry>);
  return {ids, std::move(entries), std::move(row_sums)};
}

// Returns entries of pairs without lines, which common directions have counted.
std::vector<FormFactors::Entry> LineGuarantee::countedEntries(const RunSums& sums) const {
  std::vector<FormFactors::Entry> found;
  PairWalk walk(entries_);
  for (const ReplicateSums::PairSum& pair : sums.by_id.pairs()) {
    if (pair.j >= kEnvironment || walk.find(pair)) continue;
    Measured exchange = sums.by_id.exchangeArea(pair, sums.measure_area, sums.countArea());
    exchange.value = std::min(exchange.value, options_.epsilon * ids_.smallerArea(pair.i, pair.j));
    found.push_back({pair.i, pair.j, exchange});
  }
  return found;
}

Estimate LineGuarantee::estimate(const RunSums& sums, double relative_floor) const {
  std::vector<FormFactors::Entry> entries;
  Estimate estimate{FormFactors({}, {}, {}), FormFactors({}, {}, {})};
  // A guarantee without lines holds for certain, and includes the environment.
  const bool needs_lines = figures_.drawn || (ids_.counts_environment && !parts_.empty());
  Guarantee guarantee{options_.epsilon, needs_lines ? options_.delta : 0, 0, GuaranteedBy::chernoff};
  for (const Entry& entry : entries_) {
    entries.push_back({entry.i, entry.j, {entry.value, entry.standard_error}});
    estimate.line_pairs += entry.part_count > 0;
    for (uint32_t k = 0; k < entry.part_count; ++k) {
      const Part& part = parts_[entry.first_part + k];
      estimate.lines += part.count.lines + part.strata_lines;
    }
    if (isOutsideResult(entry)) continue;
    const double off = std::max(entry.interval.upper - entry.value, entry.value - entry.interval.lower);
    guarantee.bound = std::max(guarantee.bound, off / ids_.smallerArea(entry.i, entry.j));
  }
  if (options_.least_form_factor > 0) {
    const std::vector<FormFactors::Entry> counted = countedEntries(sums);
    const auto lined = static_cast<std::ptrdiff_t>(entries.size());
    entries.insert(entries.end(), counted.begin(), counted.end());
    std::ranges::inplace_merge(entries, entries.begin() + lined, {}, keyOf<FormFactors::Entry>);
    guarantee.bound = options_.epsilon;
  }
  const bool by_polygon = options_.by == By::polygon;
  const ReplicateSums& counted = by_polygon ? sums.by_id : sums.by_surface;
  FormFactors all = lineFormFactors(entries, {}, By::polygon, counted, sums.measure_area);
  estimate.between_surfaces = by_polygon ? lineFormFactors(std::move(entries), face_ids_.surface, By::surface,
                                                           sums.by_surface, sums.measure_area)
                                         : all;
  estimate.between_surfaces = keepSeen(withoutBlockers(std::move(estimate.between_surfaces)));
  estimate.replicates = look_;
  estimate.directions = sums.directions;
  const auto measure = [&](const FormFactors& listed) {
    estimate.largest_standard_error = largestStandardError(listed);
    estimate.largest_relative_error = largestRelativeError(listed, relative_floor);
  };
  ids_.only_blocks.empty() ? measure(all) : measure(withoutBlockers(all));
  estimate.interrupted = !isDone();
  if (!isDone()) {
    estimate.form_factors = keepSeen(withoutBlockers(std::move(all)));
    return estimate;
  }
  all = withEveryEnvironment(std::move(all));
  std::vector<Interval> intervals = findIntervals(all);
  std::vector<Measured> row_sums = all.rowSums();
  const Ids ids = all.ids();
  std::vector<FormFactors::Entry> found = std::move(all).entries();
  // The environment's value is 1 less the row's other values; its interval follows from other sums.
  for (size_t k = 0; k < found.size(); ++k) {
    double& value = found[k].exchange_area.value;
    value = std::clamp(value, intervals[k].lower, intervals[k].upper);
    if (found[k].j != kEnvironment) continue;
    const double off = std::max(intervals[k].upper - value, value - intervals[k].lower) / ids.areas[found[k].i];
    guarantee.row_bound = std::max(guarantee.row_bound, off);
  }
  const double unlisted_bound = options_.least_form_factor > 0 ? options_.epsilon : 0;
  estimate.form_factors =
      withoutBlockers({ids, std::move(found), std::move(row_sums), std::move(intervals), unlisted_bound});
  estimate.guarantee = guarantee;
  return estimate;
}

}  // namespace viewpeel
