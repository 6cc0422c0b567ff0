#include <viewpeel/form_factors.h>

#include <algorithm>
#include <utility>

namespace viewpeel {

FormFactors::FormFactors(Ids ids, std::vector<Entry> entries, std::vector<Measured> row_sums,
                         std::vector<Interval> intervals, double unlisted_bound)
    : ids_(std::move(ids)),
      entries_(std::move(entries)),
      row_sums_(std::move(row_sums)),
      intervals_(std::move(intervals)),
      unlisted_bound_(unlisted_bound) {}

size_t FormFactors::find(uint32_t i, uint32_t j) const {
  const std::pair key(std::min(i, j), std::max(i, j));
  const auto key_of = [](const Entry& entry) { return std::pair(entry.i, entry.j); };
  const auto at = std::ranges::lower_bound(entries_, key, {}, key_of);
  return at != entries_.end() && key_of(*at) == key ? static_cast<size_t>(at - entries_.begin()) : entries_.size();
}

Measured FormFactors::exchangeArea(uint32_t i, uint32_t j) const {
  const size_t at = find(i, j);
  return at < entries_.size() ? entries_[at].exchange_area : Measured{};
}

Interval FormFactors::interval(uint32_t i, uint32_t j) const {
  const size_t at = find(i, j);
  if (at >= intervals_.size()) return {0, unlisted_bound_ * std::min(1.0, ids_.smallerArea(i, j) / ids_.areas[i])};
  return {intervals_[at].lower / ids_.areas[i], intervals_[at].upper / ids_.areas[i]};
}

Measured FormFactors::formFactor(uint32_t i, uint32_t j) const {
  const Measured exchange = exchangeArea(i, j);
  return {exchange.value / ids_.areas[i], exchange.standard_error / ids_.areas[i]};
}

}  // namespace viewpeel
