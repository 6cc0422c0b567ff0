#include <viewpeel/drop_below.h>

#include <algorithm>
#include <cmath>

namespace viewpeel {

DroppedBelow dropBelow(const FormFactors& form_factors, double least) {
  const Ids& ids = form_factors.ids();
  const std::vector<FormFactors::Entry>& entries = form_factors.entries();
  const bool has_intervals = form_factors.hasIntervals();
  std::vector<FormFactors::Entry> kept;
  std::vector<Interval> intervals;
  double unlisted_bound = form_factors.unlistedBound();
  DroppedSums dropped{least, std::vector<Measured>(ids.count()), 0};
  const auto addTo = [&](uint32_t id, const Measured& exchange) {
    dropped.sums[id].value += exchange.value / ids.areas[id];
    dropped.sums[id].standard_error =
        std::hypot(dropped.sums[id].standard_error, exchange.standard_error / ids.areas[id]);
  };
  for (size_t k = 0; k < entries.size(); ++k) {
    const FormFactors::Entry& entry = entries[k];
    // Of F_ij and F_ji the form factor from the smaller area is larger; only requested rows count.
    const double area = ids.smallerArea(entry.i, entry.j);
    if (entry.j >= kEnvironment || !(entry.exchange_area.value < least * area)) {
      kept.push_back(entry);
      if (has_intervals) intervals.push_back(form_factors.intervals()[k]);
      continue;
    }
    ++dropped.pairs;
    if (has_intervals) unlisted_bound = std::max(unlisted_bound, form_factors.intervals()[k].upper / area);
    addTo(entry.i, entry.exchange_area);
    if (entry.i != entry.j) addTo(entry.j, entry.exchange_area);
  }
  return {FormFactors(ids, std::move(kept), form_factors.rowSums(), std::move(intervals), unlisted_bound),
          std::move(dropped)};
}

}  // namespace viewpeel
