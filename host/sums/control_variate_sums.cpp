#include "sums/control_variate_sums.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "sums/add_pairs.h"
#include "sums/pair_walk.h"

namespace viewpeel {
namespace {

void addExactly(ControlVariateSums::Wide& sum, ControlVariateSums::Wide more) {
  if (__builtin_add_overflow(sum, more, &sum))
    throw Error(ErrorCode::bad_usage,
                "the squares of counts of so many replicates are beyond 128 bits; ask for fewer --directions in each, "
                "or --unoccluded off");
}

}  // namespace

PairCounts withRows(PairCounts counts, std::span<const PairVisibility> others) {
  std::vector<uint64_t> rows;
  const auto addTo = [&](uint32_t id, uint64_t count) {
    if (id >= rows.size()) rows.resize(id + 1, 0);
    rows[id] += count;
  };
  for (const PairCount& count : counts) {
    addTo(count.i, count.count);
    if (count.j < kEnvironment) addTo(count.j, count.count);  // a pair (i, i) counts twice in its row
  }
  for (PairCount& count : counts)
    if (count.j >= kEnvironment) count.blocked = rows[count.i] - count.count;
  PairCounts missing;
  for (const PairVisibility& pair : others)
    if (pair.j >= kEnvironment && pair.i < rows.size() && rows[pair.i] > 0)
      missing.push_back({pair.i, pair.j, 0, rows[pair.i]});
  PairCounts all;
  all.reserve(counts.size() + missing.size());
  // A pair that is in both lists is taken from `counts`.
  std::ranges::set_union(counts, missing, std::back_inserter(all), isBefore);
  return all;
}

void requireCountsForVisibilities(const PairCount& count) {
  if (std::max(count.count, count.blocked) > kMostCounts)
    throw Error(ErrorCode::bad_usage,
                fmt::format("a replicate's counts of a pair, {}, are too large for unoccluded form factors; "
                            "ask for fewer --directions and more --replicates, or "
                            "--unoccluded off",
                            std::max(count.count, count.blocked)));
}

uint64_t lineOf(const std::vector<uint64_t>& lines, uint32_t i, uint32_t j) {
  if (lines.empty()) return 1;
  return j < kEnvironment ? std::min(lines[i], lines[j]) : lines[i];
}

std::vector<ControlVariate> takeControlVariates(const PairCounts& counts,
                                                const std::vector<PairVisibility>& visibilities,
                                                const std::vector<uint64_t>& lines) {
  std::vector<ControlVariate> controls;
  controls.reserve(counts.size());
  PairWalk walk(visibilities);
  for (const PairCount& count : counts) {
    requireCountsForVisibilities(count);
    const PairVisibility* const visibility = walk.find(count);
    const uint64_t b = visibility ? visibility->visibility : 0;
    const auto control =
        static_cast<int64_t>(count.count * (kVisibilityOne - b)) - static_cast<int64_t>(count.blocked * b);
    const uint64_t line = lineOf(lines, count.i, count.j);
    // V / line lines are facing, and each adds line (1 - b); O / line lines are blocked, and each takes off line b.
    const ControlVariate::Wide squares =
        (ControlVariate::Wide(count.count) * (kVisibilityOne - b) * (kVisibilityOne - b) +
         ControlVariate::Wide(count.blocked) * b * b) *
        line;
    if (squares) controls.push_back({count.i, count.j, control, squares, line});
  }
  return controls;
}

std::vector<ControlVariate> mergeIds(const std::vector<ControlVariate>& controls, const std::vector<uint32_t>& id_map) {
  return mergePairs(controls, id_map, [](ControlVariate& sum, const ControlVariate& control) {
    sum.control += control.control;
    sum.squares += control.squares;
    sum.line = std::max(sum.line, control.line);
  });
}

// `surplus` is D of docs/method.md, eq. (12), and at_a_time is D_1, the number of lines that come together.
double errorOfSum(double variance, double squares, double line, double most) {
  double surplus = line;
  if (squares > 0) {
    const double at_a_time = std::max(1.0, variance / squares), lines = squares / line / line;
    surplus *= (lines + 1 + 8 / 27.0 * most / line) / (lines / at_a_time + 1);
  }
  return std::sqrt(variance + surplus * surplus);
}

Measured allowForUnmet(Measured exchange, const PriorExchange& prior, double directions, double area) {
  if (prior.j >= kEnvironment || std::isinf(prior.most)) return exchange;
  const double unmet = prior.most * std::exp(-directions * prior.most / (2 * area));
  exchange.standard_error =
      std::max(exchange.standard_error, std::min(unmet, std::max(exchange.value, prior.most - exchange.value)));
  return exchange;
}

void ControlVariateSums::add(const std::vector<ControlVariate>& controls) {
  ++replicate_count_;  // comes first, so that RunSums::isWhole notices where an exception ends this call
  addPairs(pairs_, controls, [](PairSum& sum, const ControlVariate& control) {
    sum.line = std::max(sum.line, control.line);
    sum.sum += control.control;
    addExactly(sum.sum_of_squares, Wide(SignedWide(control.control) * control.control));
    addExactly(sum.squares, control.squares);
  });
}

void ControlVariateSums::add(const ControlVariateSums& others) {
  replicate_count_ += others.replicate_count_;
  addPairs(pairs_, others.pairs_, [](PairSum& sum, const PairSum& other) {
    sum.line = std::max(sum.line, other.line);
    sum.sum += other.sum;
    addExactly(sum.sum_of_squares, other.sum_of_squares);
    addExactly(sum.squares, other.squares);
  });
}

double ControlVariateSums::variance(const PairSum& pair, double measure_area) const {
  const auto replicates = static_cast<long double>(replicate_count_), sum = static_cast<long double>(pair.sum);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area / kVisibilityOne;
  return static_cast<double>(std::max(0.0L, static_cast<long double>(pair.sum_of_squares) - sum * sum / replicates) /
                             (replicates - 1)) *
         scale * scale;
}

Measured ControlVariateSums::measure(const PairSum& pair, double measure_area, const PriorExchange* prior,
                                     double count_area) const {
  constexpr auto kOne = static_cast<double>(kVisibilityOne);
  const auto replicates = static_cast<long double>(replicate_count_);
  const double scale = (pair.i == pair.j ? 4 : 2) * measure_area, most = prior ? prior->most : INFINITY;
  const long double mean = static_cast<long double>(pair.sum) / replicates;
  Measured exchange{static_cast<double>(mean / kOne) * scale + (prior ? prior->area : 0), INFINITY};
  exchange.value = std::clamp(exchange.value, 0.0, most);
  if (replicate_count_ < 2) return exchange;
  // This is R s^2, the variance of the sum over R replicates.
  const long double variance =
      std::max(0.0L, (static_cast<long double>(pair.sum_of_squares) - mean * static_cast<long double>(pair.sum)) *
                         replicates / (replicates - 1));
  const double area = std::min(ids_.areas[pair.i], pair.j < kEnvironment ? ids_.areas[pair.j] : INFINITY);
  const auto line = static_cast<double>(pair.squares || !prior ? pair.line : prior->line);
  exchange.standard_error = errorOfSum(static_cast<double>(variance) / kOne / kOne,
                                       static_cast<double>(pair.squares) / kOne / kOne, line, area / count_area) /
                            static_cast<double>(replicates) * scale;
  exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, most - exchange.value));
  return exchange;
}

Measured ControlVariateSums::allowForUnmetPair(const Measured& exchange, double measure_area,
                                               const PriorExchange& prior, double count_area) const {
  if (replicate_count_ < 2 || prior.j >= kEnvironment) return exchange;
  return viewpeel::allowForUnmet(exchange, prior, double(replicate_count_) * count_area / measure_area,
                                 std::min(ids_.areas[prior.i], ids_.areas[prior.j]));
}

FormFactors ControlVariateSums::allowForUnmet(const FormFactors& form_factors, double measure_area,
                                              const std::vector<PriorExchange>& prior, double count_area) const {
  std::vector<FormFactors::Entry> entries = form_factors.entries();
  PairWalk sums(pairs_);
  PairWalk priors(prior);
  for (FormFactors::Entry& entry : entries)
    if (const PriorExchange* const of_prior = priors.find(entry); of_prior && !sums.find(entry))
      entry.exchange_area = allowForUnmetPair(entry.exchange_area, measure_area, *of_prior, count_area);
  return {form_factors.ids(), std::move(entries), form_factors.rowSums()};
}

FormFactors ControlVariateSums::formFactors(double measure_area, const std::vector<PriorExchange>& prior,
                                            double count_area) const {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(pairs_.size());
  auto at = prior.begin();
  const auto addUnmet = [&](const PriorExchange& unmet) {
    entries.push_back({unmet.i, unmet.j, measure({unmet.i, unmet.j}, measure_area, &unmet, count_area)});
  };
  for (const PairSum& pair : pairs_) {
    for (; at != prior.end() && keyOf(*at) < keyOf(pair); ++at) addUnmet(*at);
    const bool has_prior = at != prior.end() && keyOf(*at) == keyOf(pair);
    entries.push_back({pair.i, pair.j, measure(pair, measure_area, has_prior ? &*at : nullptr, count_area)});
    if (has_prior) ++at;
  }
  for (; at != prior.end(); ++at) addUnmet(*at);
  return {ids_, std::move(entries), {}};
}

Measured ControlVariateSums::exchangeArea(double measure_area, const PriorExchange& prior, double count_area) const {
  const auto at =
      std::lower_bound(pairs_.begin(), pairs_.end(), prior,
                       [](const PairSum& pair, const PriorExchange& key) { return keyOf(pair) < keyOf(key); });
  const bool has_sum = at != pairs_.end() && keyOf(*at) == keyOf(prior);
  const Measured exchange = measure(has_sum ? *at : PairSum{prior.i, prior.j}, measure_area, &prior, count_area);
  return has_sum ? exchange : allowForUnmetPair(exchange, measure_area, prior, count_area);
}

FormFactors chooseBetter(const FormFactors& controlled, const FormFactors& sampled) {
  std::vector<FormFactors::Entry> entries;
  entries.reserve(controlled.entries().size());
  PairWalk walk(sampled.entries());
  for (const FormFactors::Entry& entry : controlled.entries()) {
    const FormFactors::Entry* const other = walk.find(entry);
    entries.push_back(other && 2 * other->exchange_area.standard_error < entry.exchange_area.standard_error ? *other
                                                                                                            : entry);
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
