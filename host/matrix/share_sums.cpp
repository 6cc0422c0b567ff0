#include "matrix/share_sums.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "matrix/add_pairs.h"
#include "threads.h"

namespace viewpeel {

void ShareSums::add(const PairCounts& counts) {
  ++replicate_count_;  // first: what ends early is seen (RunSums::isWhole)
  addPairs(pairs_, counts, [](PairSum& sum, const PairCount& count) {
    requireCountsForShares(count);
    sum.facing += count.count;
    sum.blocked += count.blocked;
    sum.facing_squared += Wide(count.count) * count.count;
    sum.product += Wide(count.count) * count.blocked;
    sum.blocked_squared += Wide(count.blocked) * count.blocked;
  });
}

void ShareSums::add(const ShareSums& others) {
  replicate_count_ += others.replicate_count_;
  addPairs(pairs_, others.pairs_, [](PairSum& sum, const PairSum& other) {
    sum.facing += other.facing;
    sum.blocked += other.blocked;
    sum.facing_squared += other.facing_squared;
    sum.product += other.product;
    sum.blocked_squared += other.blocked_squared;
  });
}

Measured ShareSums::measure(const PairSum& pair, double measure_area, const KnownExchange& known, double count_area) const {
  const auto replicates = static_cast<double>(replicate_count_), facing = double(pair.facing), blocked = double(pair.blocked), lines = facing + blocked;
  const double b = lines > 0 ? facing / lines : 0;
  const bool is_share = lines > 0 && !std::isinf(known.most);
  Measured exchange{is_share ? b * known.most : known.area, INFINITY};
  if (replicate_count_ < 2) return exchange;
  const double area = std::min(ids_.areas[pair.i], pair.j < kEnvironment ? ids_.areas[pair.j] : INFINITY);
  // The replicates' variance in units of counts: of residuals (1 - b) V_r - b O_r, whose sum is 0; and of lines, each by chance of its own.
  const double residuals = (1 - b) * (1 - b) * double(pair.facing_squared) - 2 * b * (1 - b) * double(pair.product) + b * b * double(pair.blocked_squared);
  const double variance = std::max(0.0, residuals) * replicates / (replicates - 1), squares = b * blocked * double(known.line);
  const double count_exchange = is_share ? known.most / lines : (pair.i == pair.j ? 4 : 2) * measure_area / replicates;
  exchange.standard_error = errorOfSum(variance, squares, double(known.line), area / count_area) * count_exchange;
  exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, known.most - exchange.value));
  return squares > 0 ? exchange : allowForUnmet(exchange, known, replicates * count_area / measure_area, area);
}

FormFactors ShareSums::formFactors(const std::vector<KnownPair>& known, const std::vector<uint64_t>& lines, double measure_area, double count_area, const FormFactors& sampled) const {
  // Parts of the known pairs, each with what lies between its first pair and the next part's.
  constexpr size_t kPart = size_t(1) << 16;
  std::vector<std::vector<FormFactors::Entry>> parts(std::max<size_t>(1, (known.size() + kPart - 1) / kPart));
  const auto addPart = [&](size_t, size_t part) {
    std::vector<FormFactors::Entry>& entries = parts[part];
    const size_t first = part * kPart, end = std::min(first + kPart, known.size());
    const auto from = [&](const auto& pairs) {
      return part ? std::lower_bound(pairs.begin(), pairs.end(), keyOf(known[first]), [](const auto& pair, const auto& key) { return keyOf(pair) < key; }) : pairs.begin();
    };
    auto pair = from(pairs_);
    auto other = from(sampled.entries());
    const auto others_end = sampled.entries().end();
    for (size_t k = first; k < end; ++k) {
      const KnownPair& at = known[k];
      for (; other != others_end && keyOf(*other) < keyOf(at); ++other) entries.push_back(*other);
      while (pair != pairs_.end() && keyOf(*pair) < keyOf(at)) ++pair;
      const bool is_told = pair != pairs_.end() && keyOf(*pair) == keyOf(at), is_sampled = other != others_end && keyOf(*other) == keyOf(at);
      if (is_sampled && std::isinf(at.exchange)) entries.push_back(*other);
      else entries.push_back({at.i, at.j, measure(is_told ? *pair : PairSum{at.i, at.j}, measure_area, exchangeOf(at, at.share, ids_.areas, lines), count_area)});
      if (is_sampled) ++other;
    }
    for (; other != others_end && (end == known.size() || keyOf(*other) < keyOf(known[end])); ++other) entries.push_back(*other);
  };
  shareOut(threadsFor(known.size()), parts.size(), 1, addPart);
  std::vector<FormFactors::Entry> entries = std::move(parts[0]);
  for (size_t part = 1; part < parts.size(); ++part) entries.insert(entries.end(), parts[part].begin(), parts[part].end());
  return {ids_, std::move(entries), sampled.rowSums()};
}

ControlSums ShareSums::controls(const std::vector<PairShare>& shares, const std::vector<uint64_t>& lines) const {
  std::vector<ControlSums::PairSum> controls;
  auto share = shares.begin();
  for (const PairSum& pair : pairs_) {
    while (share != shares.end() && keyOf(*share) < keyOf(pair)) ++share;
    const Wide b = share != shares.end() && keyOf(*share) == keyOf(pair) ? share->share : 0, rest = kShareOne - b;
    ControlSums::PairSum control{pair.i, pair.j};
    control.line = lineOf(lines, pair.i, pair.j);
    control.squares = (pair.facing * rest * rest + pair.blocked * b * b) * control.line;
    if (control.squares == 0) continue;
    control.sum = static_cast<ControlSums::SignedWide>(pair.facing * rest) - static_cast<ControlSums::SignedWide>(pair.blocked * b);
    control.sum_of_squares = rest * rest * pair.facing_squared + b * b * pair.blocked_squared - 2 * b * rest * pair.product;
    controls.push_back(control);
  }
  return {ids_, replicate_count_, std::move(controls)};
}

}  // namespace viewpeel
