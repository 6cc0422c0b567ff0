#include "matrix/control_sums.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "error.h"

namespace viewpeel {
namespace {

constexpr uint64_t kMostCounts = uint64_t(1) << 50;  // with kShareBits more the squares of 2^3 replicates are within 128 bits


template <class Pair>
std::pair<uint32_t, uint32_t> keyOf(const Pair& pair) {
  return {pair.i, pair.j};
}

}  // namespace

PairCounts withRows(PairCounts counts) {
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
  return counts;
}

std::vector<ControlCount> takeShares(const PairCounts& counts, const std::vector<PairShare>& shares, const std::vector<uint64_t>& lines) {
  std::vector<ControlCount> controls;
  controls.reserve(counts.size());
  auto share = shares.begin();
  for (const PairCount& count : counts) {
    if (std::max(count.count, count.blocked) > kMostCounts)
      throw Error(ErrorCode::bad_usage, fmt::format("a replicate's counts of a pair, {}, are too large for closed forms; ask for fewer --directions and more --replicates, or "
                                                    "--closed-forms off", std::max(count.count, count.blocked)));
    while (share != shares.end() && keyOf(*share) < keyOf(count)) ++share;
    const uint64_t b = share != shares.end() && keyOf(*share) == keyOf(count) ? share->share : 0;
    const auto control = static_cast<int64_t>(count.count * (kShareOne - b)) - static_cast<int64_t>(count.blocked * b);
    const uint64_t line = lines.empty() ? 1 : count.j < kEnvironment ? std::min(lines[count.i], lines[count.j]) : lines[count.i];
    // count / line lines, each of which adds `line` times 1 - b
    const ControlCount::Wide squares = (ControlCount::Wide(count.count) * (kShareOne - b) * (kShareOne - b) + ControlCount::Wide(count.blocked) * b * b) * line;
    if (squares) controls.push_back({count.i, count.j, control, squares, line});
  }
  return controls;
}

std::vector<ControlCount> mergeIds(const std::vector<ControlCount>& controls, const std::vector<uint32_t>& id_map) {
  std::vector<ControlCount> mapped;
  mapped.reserve(controls.size());
  for (const ControlCount& control : controls) {
    const uint32_t i = id_map[control.i], j = control.j < kEnvironment ? id_map[control.j] : control.j;
    mapped.push_back({std::min(i, j), std::max(i, j), control.control, control.squares, control.line});
  }
  std::sort(mapped.begin(), mapped.end(), [](const auto& a, const auto& b) { return keyOf(a) < keyOf(b); });
  std::vector<ControlCount> merged;
  for (const ControlCount& control : mapped) {
    if (merged.empty() || keyOf(merged.back()) != keyOf(control)) {
      merged.push_back(control);
      continue;
    }
    merged.back().control += control.control;
    merged.back().squares += control.squares;
    merged.back().line = std::max(merged.back().line, control.line);
  }
  return merged;
}

// The sums with others, sorted alike, added: add_to(sum, pair) for each of them.
template <class Pairs, class AddTo>
std::vector<ControlSums::PairSum> ControlSums::addPairs(const Pairs& pairs, AddTo add_to) const {
  std::vector<PairSum> merged;
  merged.reserve(std::max(pairs_.size(), pairs.size()));
  auto old = pairs_.begin();
  for (const auto& pair : pairs) {
    while (old != pairs_.end() && keyOf(*old) < keyOf(pair)) merged.push_back(*old++);
    merged.push_back(old != pairs_.end() && keyOf(*old) == keyOf(pair) ? *old++ : PairSum{pair.i, pair.j});
    merged.back().line = std::max(merged.back().line, pair.line);
    add_to(merged.back(), pair);
  }
  merged.insert(merged.end(), old, pairs_.end());
  return merged;
}

void ControlSums::add(const std::vector<ControlCount>& controls) {
  pairs_ = addPairs(controls, [](PairSum& sum, const ControlCount& control) {
    sum.sum += control.control;
    sum.sum_of_squares += Wide(SignedWide(control.control) * control.control);
    sum.squares += control.squares;
  });
  ++replicate_count_;
}

void ControlSums::add(const ControlSums& others) {
  pairs_ = addPairs(others.pairs_, [](PairSum& sum, const PairSum& other) {
    sum.sum += other.sum;
    sum.sum_of_squares += other.sum_of_squares;
    sum.squares += other.squares;
  });
  replicate_count_ += others.replicate_count_;
}

double ControlSums::variance(const PairSum& pair, double measure_area) const {
  const auto replicates = static_cast<long double>(replicate_count_), sum = static_cast<long double>(pair.sum);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area / kShareOne;
  return static_cast<double>(std::max(0.0L, static_cast<long double>(pair.sum_of_squares) - sum * sum / replicates) / (replicates - 1)) * scale * scale;
}

Measured ControlSums::measure(const PairSum& pair, double measure_area, const KnownExchange* known, double count_area) const {
  const auto replicates = static_cast<long double>(replicate_count_);
  const double line = kShareOne * double(pair.squares || !known ? pair.line : known->line);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area / kShareOne, most = known ? known->most : INFINITY;
  const long double mean = static_cast<long double>(pair.sum) / replicates;
  Measured exchange{static_cast<double>(mean) * scale + (known ? known->area : 0), INFINITY};
  exchange.value = std::clamp(exchange.value, 0.0, most);
  if (replicate_count_ < 2) return exchange;
  // R s^2, the variance of the sum over replicates
  const long double variance = std::max(0.0L, (static_cast<long double>(pair.sum_of_squares) - mean * static_cast<long double>(pair.sum)) * replicates / (replicates - 1));
  const double area = std::min(ids_.areas[pair.i], pair.j < kEnvironment ? ids_.areas[pair.j] : INFINITY);
  long double surplus = line;
  if (pair.squares) {
    // Lines at a time: the variance over what that of independent lines would be; one at least. D as in ReplicateSums.
    const long double at_a_time = std::max(1.0L, variance / static_cast<long double>(pair.squares)), lines = static_cast<long double>(pair.squares) / line / line;
    surplus *= (lines + 1 + 8 / 27.0L * area * kShareOne / (count_area * line)) / (lines / at_a_time + 1);
  }
  exchange.standard_error = static_cast<double>(std::sqrt(variance + surplus * surplus) / replicates) * scale;
  exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, most - exchange.value));
  return exchange;
}

Measured ControlSums::allowForUnmet(Measured exchange, double measure_area, const KnownExchange& known, double count_area) const {
  if (known.j >= kEnvironment || std::isinf(known.most) || replicate_count_ < 2) return exchange;
  const double directions = double(replicate_count_) * count_area / measure_area, area = std::min(ids_.areas[known.i], ids_.areas[known.j]);
  const double unmet = known.most * std::exp(-directions * known.most / (2 * area));
  exchange.standard_error = std::max(exchange.standard_error, std::min(unmet, std::max(exchange.value, known.most - exchange.value)));
  return exchange;
}

FormFactors ControlSums::allowForUnmet(const FormFactors& form_factors, double measure_area, const std::vector<KnownExchange>& known, double count_area) const {
  std::vector<FormFactors::Entry> entries = form_factors.entries();
  auto told = pairs_.begin();
  auto at = known.begin();
  for (FormFactors::Entry& entry : entries) {
    while (told != pairs_.end() && keyOf(*told) < keyOf(entry)) ++told;
    while (at != known.end() && keyOf(*at) < keyOf(entry)) ++at;
    const bool is_told = told != pairs_.end() && keyOf(*told) == keyOf(entry), is_known = at != known.end() && keyOf(*at) == keyOf(entry);
    if (is_known && !is_told) entry.exchange_area = allowForUnmet(entry.exchange_area, measure_area, *at, count_area);
  }
  return {form_factors.ids(), std::move(entries), form_factors.rowSums()};
}

FormFactors ControlSums::formFactors(double measure_area, const std::vector<KnownExchange>& known, double count_area) const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  auto at = known.begin();
  const auto addUnmet = [&](const KnownExchange& unmet) { entries.push_back({unmet.i, unmet.j, measure({unmet.i, unmet.j}, measure_area, &unmet, count_area)}); };
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
  const auto at = std::lower_bound(pairs_.begin(), pairs_.end(), known, [](const PairSum& pair, const KnownExchange& key) { return keyOf(pair) < keyOf(key); });
  const bool is_told = at != pairs_.end() && keyOf(*at) == keyOf(known);
  const Measured exchange = measure(is_told ? *at : PairSum{known.i, known.j}, measure_area, &known, count_area);
  return is_told ? exchange : allowForUnmet(exchange, measure_area, known, count_area);
}

FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled) {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(controlled.entries().size());
  auto other = sampled.entries().begin();
  for (const FormFactors::Entry& entry : controlled.entries()) {
    while (other != sampled.entries().end() && keyOf(*other) < keyOf(entry)) ++other;
    const bool has_other = other != sampled.entries().end() && keyOf(*other) == keyOf(entry);
    entries.push_back(has_other && 2 * other->exchange_area.standard_error < entry.exchange_area.standard_error ? *other : entry);
  }
  return {controlled.ids(), std::move(entries), sampled.rowSums()};
}

double largestStandardError(const FormFactors& form_factors) {
  const Ids& ids = form_factors.ids();
  double largest = 0;
  for (const auto& entry : form_factors.entries()) {
    double area = ids.isAsked(entry.i) ? ids.areas[entry.i] : INFINITY;
    if (entry.j < kEnvironment && ids.isAsked(entry.j)) area = std::min(area, ids.areas[entry.j]);
    largest = std::max(largest, entry.exchange_area.standard_error / area);
  }
  return largest;
}

double largestRelativeError(const FormFactors& form_factors, double floor) {
  const Ids& ids = form_factors.ids();
  double largest = 0;
  for (const auto& entry : form_factors.entries()) {
    double area = ids.isAsked(entry.i) ? ids.areas[entry.i] : INFINITY;
    if (entry.j < kEnvironment && ids.isAsked(entry.j)) area = std::min(area, ids.areas[entry.j]);
    if (entry.exchange_area.value / area >= floor) largest = std::max(largest, entry.exchange_area.standard_error / entry.exchange_area.value);
  }
  return largest;
}

}  // namespace viewpeel
