#include "matrix/control_sums.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace viewpeel {
namespace {

template <class Pair>
std::pair<uint32_t, uint32_t> keyOf(const Pair& pair) {
  return {pair.i, pair.j};
}

}  // namespace

std::vector<ControlCount> takeShares(const PairCounts& counts, const std::vector<PairShare>& shares) {
  std::vector<ControlCount> controls;
  controls.reserve(counts.size());
  auto share = shares.begin();
  for (const PairCount& count : counts) {
    while (share != shares.end() && keyOf(*share) < keyOf(count)) ++share;
    const uint64_t b = share != shares.end() && keyOf(*share) == keyOf(count) ? share->share : 0;
    const auto control = static_cast<int64_t>(count.count * (kShareOne - b)) - static_cast<int64_t>(count.blocked * b);
    const ControlCount::Wide squares = ControlCount::Wide(count.count) * (kShareOne - b) * (kShareOne - b) + ControlCount::Wide(count.blocked) * b * b;
    if (squares) controls.push_back({count.i, count.j, control, squares});
  }
  return controls;
}

std::vector<ControlCount> mergeIds(const std::vector<ControlCount>& controls, const std::vector<uint32_t>& id_map) {
  std::vector<ControlCount> mapped;
  mapped.reserve(controls.size());
  for (const ControlCount& control : controls) {
    const uint32_t i = id_map[control.i], j = control.j < kEnvironment ? id_map[control.j] : control.j;
    mapped.push_back({std::min(i, j), std::max(i, j), control.control, control.squares});
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
  }
  return merged;
}

void ControlSums::add(const std::vector<ControlCount>& controls) {
  std::vector<PairSum> merged;
  merged.reserve(std::max(pairs_.size(), controls.size()));
  auto old = pairs_.begin();
  for (const ControlCount& control : controls) {
    while (old != pairs_.end() && keyOf(*old) < keyOf(control)) merged.push_back(*old++);
    merged.push_back(old != pairs_.end() && keyOf(*old) == keyOf(control) ? *old++ : PairSum{control.i, control.j});
    PairSum& sum = merged.back();
    sum.sum += control.control;
    sum.sum_of_squares += Wide(SignedWide(control.control) * control.control);
    sum.squares += control.squares;
  }
  merged.insert(merged.end(), old, pairs_.end());
  pairs_ = std::move(merged);
  ++replicate_count_;
}

FormFactors ControlSums::formFactors(double measure_area, const std::vector<KnownExchange>& known) const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  const auto replicates = static_cast<long double>(replicate_count_);
  const auto add = [&](uint32_t i, uint32_t j, const PairSum& pair, const KnownExchange* more) {
    const double scale = (i == j ? 4 : 2) * measure_area / kShareOne;
    const long double mean = static_cast<long double>(pair.sum) / replicates;
    // R s^2, the variance of the sum over replicates
    const long double variance = std::max(0.0L, (static_cast<long double>(pair.sum_of_squares) - mean * static_cast<long double>(pair.sum)) * replicates / (replicates - 1));
    // Lines at a time: the variance over what that of independent lines would be; one at least.
    const long double together = pair.squares ? kShareOne * std::max(1.0L, variance / static_cast<long double>(pair.squares)) : kShareOne;
    Measured exchange{static_cast<double>(mean) * scale + (more ? more->area : 0),
                      replicate_count_ < 2 ? INFINITY : static_cast<double>(std::sqrt(variance + together * together) / replicates) * scale};
    exchange.value = std::clamp(exchange.value, 0.0, more ? more->most : INFINITY);
    entries.push_back({i, j, exchange});
  };
  auto at = known.begin();
  for (const PairSum& pair : pairs_) {
    for (; at != known.end() && keyOf(*at) < keyOf(pair); ++at) add(at->i, at->j, {at->i, at->j}, &*at);
    const bool is_known = at != known.end() && keyOf(*at) == keyOf(pair);
    add(pair.i, pair.j, pair, is_known ? &*at : nullptr);
    if (is_known) ++at;
  }
  for (; at != known.end(); ++at) add(at->i, at->j, {at->i, at->j}, &*at);
  return {ids_, std::move(entries), {}};
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
