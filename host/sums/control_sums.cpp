#include "sums/control_sums.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

void addExactly(ControlSums::Wide& sum, ControlSums::Wide more) {
  if (__builtin_add_overflow(sum, more, &sum))
    throw Error(ErrorCode::bad_usage,
                "the squares of counts of so many replicates are beyond 128 bits; ask for fewer --directions in each, "
                "or --closed-forms off");
}

}  // namespace

PairCounts withRows(PairCounts counts, std::span<const PairShare> others) {
  std::vector<uint64_t> rows;
  const auto addTo = [&](uint32_t id, uint64_t count) {
    if (id >= rows.size()) rows.resize(id + 1, 0);
    rows[id] += count;
  };
  for (const PairCount& count : counts) {
    addTo(count.i, count.count);
    if (count.j < kEnvironment) addTo(count.j, count.count);  // a pair within one id counts twice
  }
  for (PairCount& count : counts)
    if (count.j >= kEnvironment) count.blocked = rows[count.i] - count.count;
  PairCounts missing;
  for (const PairShare& pair : others)
    if (pair.j >= kEnvironment && pair.i < rows.size() && rows[pair.i] > 0)
      missing.push_back({pair.i, pair.j, 0, rows[pair.i]});
  PairCounts all;
  all.reserve(counts.size() + missing.size());
  std::ranges::set_union(counts, missing, std::back_inserter(all), isBefore);  // of both, the one counted
  return all;
}

void requireCountsForShares(const PairCount& count) {
  if (std::max(count.count, count.blocked) > kMostCounts)
    throw Error(ErrorCode::bad_usage, fmt::format("a replicate's counts of a pair, {}, are too large for closed forms; "
                                                  "ask for fewer --directions and more --replicates, or "
                                                  "--closed-forms off",
                                                  std::max(count.count, count.blocked)));
}

uint64_t lineOf(const std::vector<uint64_t>& lines, uint32_t i, uint32_t j) {
  if (lines.empty()) return 1;
  return j < kEnvironment ? std::min(lines[i], lines[j]) : lines[i];
}

std::vector<ControlCount> takeShares(const PairCounts& counts, const std::vector<PairShare>& shares,
                                     const std::vector<uint64_t>& lines) {
  std::vector<ControlCount> controls;
  controls.reserve(counts.size());
  auto share = shares.begin();
  for (const PairCount& count : counts) {
    requireCountsForShares(count);
    while (share != shares.end() && keyOf(*share) < keyOf(count)) ++share;
    const uint64_t b = share != shares.end() && keyOf(*share) == keyOf(count) ? share->share : 0;
    const auto control = static_cast<int64_t>(count.count * (kShareOne - b)) - static_cast<int64_t>(count.blocked * b);
    const uint64_t line = lineOf(lines, count.i, count.j);
    // count / line lines, each of which adds `line` times 1 - b
    const ControlCount::Wide squares = (ControlCount::Wide(count.count) * (kShareOne - b) * (kShareOne - b) +
                                        ControlCount::Wide(count.blocked) * b * b) *
                                       line;
    if (squares) controls.push_back({count.i, count.j, control, squares, line});
  }
  return controls;
}

std::vector<ControlCount> mergeIds(const std::vector<ControlCount>& controls, const std::vector<uint32_t>& id_map) {
  return mergePairs(controls, id_map, [](ControlCount& sum, const ControlCount& control) {
    sum.control += control.control;
    sum.squares += control.squares;
    sum.line = std::max(sum.line, control.line);
  });
}

// Lines at a time: the variance over what that of independent lines would be; one at least. D as in ReplicateSums.
double errorOfSum(double variance, double squares, double line, double most) {
  double surplus = line;
  if (squares > 0) {
    const double at_a_time = std::max(1.0, variance / squares), lines = squares / line / line;
    surplus *= (lines + 1 + 8 / 27.0 * most / line) / (lines / at_a_time + 1);
  }
  return std::sqrt(variance + surplus * surplus);
}

Measured allowForUnmet(Measured exchange, const KnownExchange& known, double directions, double area) {
  if (known.j >= kEnvironment || std::isinf(known.most)) return exchange;
  const double unmet = known.most * std::exp(-directions * known.most / (2 * area));
  exchange.standard_error =
      std::max(exchange.standard_error, std::min(unmet, std::max(exchange.value, known.most - exchange.value)));
  return exchange;
}

void ControlSums::add(const std::vector<ControlCount>& controls) {
  ++replicate_count_;  // first: what ends early is seen (RunSums::isWhole)
  addPairs(pairs_, controls, [](PairSum& sum, const ControlCount& control) {
    sum.line = std::max(sum.line, control.line);
    sum.sum += control.control;
    addExactly(sum.sum_of_squares, Wide(SignedWide(control.control) * control.control));
    addExactly(sum.squares, control.squares);
  });
}

void ControlSums::add(const ControlSums& others) {
  replicate_count_ += others.replicate_count_;
  addPairs(pairs_, others.pairs_, [](PairSum& sum, const PairSum& other) {
    sum.line = std::max(sum.line, other.line);
    sum.sum += other.sum;
    addExactly(sum.sum_of_squares, other.sum_of_squares);
    addExactly(sum.squares, other.squares);
  });
}

double ControlSums::variance(const PairSum& pair, double measure_area) const {
  const auto replicates = static_cast<long double>(replicate_count_), sum = static_cast<long double>(pair.sum);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area / kShareOne;
  return static_cast<double>(std::max(0.0L, static_cast<long double>(pair.sum_of_squares) - sum * sum / replicates) /
                             (replicates - 1)) *
         scale * scale;
}

Measured ControlSums::measure(const PairSum& pair, double measure_area, const KnownExchange* known,
                              double count_area) const {
  constexpr auto kOne = static_cast<double>(kShareOne);
  const auto replicates = static_cast<long double>(replicate_count_);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area, most = known ? known->most : INFINITY;
  const long double mean = static_cast<long double>(pair.sum) / replicates;
  Measured exchange{static_cast<double>(mean / kOne) * scale + (known ? known->area : 0), INFINITY};
  exchange.value = std::clamp(exchange.value, 0.0, most);
  if (replicate_count_ < 2) return exchange;
  // R s^2, the variance of the sum over replicates
  const long double variance =
      std::max(0.0L, (static_cast<long double>(pair.sum_of_squares) - mean * static_cast<long double>(pair.sum)) *
                         replicates / (replicates - 1));
  const double area = std::min(ids_.areas[pair.i], pair.j < kEnvironment ? ids_.areas[pair.j] : INFINITY);
  const auto line = static_cast<double>(pair.squares || !known ? pair.line : known->line);
  exchange.standard_error = errorOfSum(static_cast<double>(variance) / kOne / kOne,
                                       static_cast<double>(pair.squares) / kOne / kOne, line, area / count_area) /
                            static_cast<double>(replicates) * scale;
  exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, most - exchange.value));
  return exchange;
}

Measured ControlSums::allowForUnmetPair(const Measured& exchange, double measure_area, const KnownExchange& known,
                                        double count_area) const {
  if (replicate_count_ < 2 || known.j >= kEnvironment) return exchange;
  return viewpeel::allowForUnmet(exchange, known, double(replicate_count_) * count_area / measure_area,
                                 std::min(ids_.areas[known.i], ids_.areas[known.j]));
}

FormFactors ControlSums::allowForUnmet(const FormFactors& form_factors, double measure_area,
                                       const std::vector<KnownExchange>& known, double count_area) const {
  std::vector<FormFactors::Entry> entries = form_factors.entries();
  auto told = pairs_.begin();
  auto at = known.begin();
  for (FormFactors::Entry& entry : entries) {
    while (told != pairs_.end() && keyOf(*told) < keyOf(entry)) ++told;
    while (at != known.end() && keyOf(*at) < keyOf(entry)) ++at;
    const bool is_told = told != pairs_.end() && keyOf(*told) == keyOf(entry),
               is_known = at != known.end() && keyOf(*at) == keyOf(entry);
    if (is_known && !is_told)
      entry.exchange_area = allowForUnmetPair(entry.exchange_area, measure_area, *at, count_area);
  }
  return {form_factors.ids(), std::move(entries), form_factors.rowSums()};
}

FormFactors ControlSums::formFactors(double measure_area, const std::vector<KnownExchange>& known,
                                     double count_area) const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  auto at = known.begin();
  const auto addUnmet = [&](const KnownExchange& unmet) {
    entries.push_back({unmet.i, unmet.j, measure({unmet.i, unmet.j}, measure_area, &unmet, count_area)});
  };
  for (const PairSum& pair : pairs_) {
    for (; at != known.end() && keyOf(*at) < keyOf(pair); ++at) addUnmet(*at);
    const bool is_known = at != known.end() && keyOf(*at) == keyOf(pair);
    entries.push_back({pair.i, pair.j, measure(pair, measure_area, is_known ? &*at : nullptr, count_area)});
    if (is_known) ++at;
  }
  for (; at != known.end(); ++at) addUnmet(*at);
  return {ids_, std::move(entries), {}};
}

Measured ControlSums::exchangeArea(double measure_area, const KnownExchange& known, double count_area) const {
  const auto at =
      std::lower_bound(pairs_.begin(), pairs_.end(), known,
                       [](const PairSum& pair, const KnownExchange& key) { return keyOf(pair) < keyOf(key); });
  const bool is_told = at != pairs_.end() && keyOf(*at) == keyOf(known);
  const Measured exchange = measure(is_told ? *at : PairSum{known.i, known.j}, measure_area, &known, count_area);
  return is_told ? exchange : allowForUnmetPair(exchange, measure_area, known, count_area);
}

FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled) {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(controlled.entries().size());
  auto other = sampled.entries().begin();
  for (const FormFactors::Entry& entry : controlled.entries()) {
    while (other != sampled.entries().end() && keyOf(*other) < keyOf(entry)) ++other;
    const bool has_other = other != sampled.entries().end() && keyOf(*other) == keyOf(entry);
    entries.push_back(
        has_other && 2 * other->exchange_area.standard_error < entry.exchange_area.standard_error ? *other : entry);
  }
  return {controlled.ids(), std::move(entries), sampled.rowSums()};
}

double largestStandardError(const FormFactors& form_factors) {
  const Ids& ids = form_factors.ids();
  double largest = 0;
  for (const auto& entry : form_factors.entries()) {
    largest = std::max(largest, entry.exchange_area.standard_error / ids.smallerArea(entry.i, entry.j));
  }
  return largest;
}

double largestRelativeError(const FormFactors& form_factors, double floor) {
  const Ids& ids = form_factors.ids();
  double largest = 0;
  for (const auto& entry : form_factors.entries()) {
    const double area = ids.smallerArea(entry.i, entry.j);
    if (entry.exchange_area.value / area >= floor)
      largest = std::max(largest, entry.exchange_area.standard_error / entry.exchange_area.value);
  }
  return largest;
}

}  // namespace viewpeel
