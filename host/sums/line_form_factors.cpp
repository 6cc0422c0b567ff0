#include "sums/line_form_factors.h"

#include <algorithm>
#include <cmath>

#include "sums/add_pairs.h"
#include "sums/calibrate_rows.h"

namespace viewpeel {
namespace {

// Merges the pairs that common directions counted into the entries of pairs with lines. No pair is among both but
// between surfaces, whose pairs of faces may be of either kind.
//   In: entries: with room for the counted pairs; least_form_factor: 0 between surfaces
void addCounted(std::vector<FormFactors::Entry>& entries, const ReplicateSums& counted, double measure_area,
                double count_area, double least_form_factor) {
  const auto toEntry = [&](const ReplicateSums::PairSum& pair) {
    Measured exchange = counted.exchangeArea(pair, measure_area, count_area);
    if (least_form_factor > 0 && pair.j < kEnvironment) {
      const double largest = least_form_factor * counted.ids().smallerArea(pair.i, pair.j);
      exchange.value = std::min(exchange.value, kMostOfCounted * largest);
      exchange.standard_error = std::min(exchange.standard_error, std::max(exchange.value, largest));
    }
    return FormFactors::Entry{pair.i, pair.j, exchange};
  };
  // Entries move to the end, from the last one on, and counted pairs are put between them.
  size_t from = entries.size(), to = from + counted.pairs().size();
  entries.resize(to);
  for (auto pair = counted.pairs().rbegin(); pair != counted.pairs().rend(); ++pair) {
    while (from > 0 && keyOf(*pair) < keyOf(entries[from - 1])) entries[--to] = entries[--from];
    entries[--to] = toEntry(*pair);
  }
  addSameKeys(entries);
}

// Adds entries of the environment to the rows that see it, and entries of leak that only common directions have
// counted.
void addEnvironmentAndLeak(std::vector<FormFactors::Entry>& entries, const ReplicateSums& counted, double measure_area,
                           double count_area) {
  const Ids& ids = counted.ids();
  std::vector<Measured> environment(ids.count()), leak(ids.count());
  bool is_open = false;
  for (const ReplicateSums::PairSum& pair : counted.pairs()) {
    if (pair.j < kEnvironment) continue;
    is_open |= pair.j == kEnvironment;
    (pair.j == kLeak ? leak : environment)[pair.i] = counted.exchangeArea(pair, measure_area, count_area);
  }
  for (const FormFactors::Entry& entry : entries)
    if (entry.j == kLeak) leak[entry.i] = {};  // the entries have this leak already
  const std::vector<Measured> rows = sumRows(entries, ids.areas);
  const auto pair_count = static_cast<std::ptrdiff_t>(entries.size());
  for (uint32_t i = 0; i < ids.count(); ++i) {
    if (!ids.isRequested(i)) continue;
    const double left = std::max(0.0, 1 - rows[i].value) * ids.areas[i], doubt = rows[i].standard_error * ids.areas[i];
    leak[i].value = std::min(leak[i].value, left);
    if (environment[i].value > 0 || (is_open && left - leak[i].value > kBeyondDoubt * doubt))
      entries.push_back({i, kEnvironment, {left - leak[i].value, std::hypot(doubt, leak[i].standard_error)}});
    if (leak[i].value > 0) entries.push_back({i, kLeak, leak[i]});
  }
  std::ranges::inplace_merge(entries, entries.begin() + pair_count, {}, keyOf<FormFactors::Entry>);
}

}  // namespace

FormFactors lineFormFactors(const LineSums& lines, By by, const ReplicateSums& counted, double measure_area,
                            double count_area) {
  if (lines.leastFormFactor() == 0)
    return lineFormFactors(lines.entries(), lines.ids().surface, by, counted, measure_area, count_area);
  const Ids& ids = counted.ids();
  std::vector<FormFactors::Entry> entries = lines.entries(by == By::polygon ? counted.pairs().size() : 0);
  if (by == By::surface) entries = mergeBySurface(std::move(entries), lines.ids().surface);
  std::vector<Measured> rows = sumRows(entries, ids.areas);
  addCounted(entries, counted, measure_area, count_area, by == By::polygon ? lines.leastFormFactor() : 0);
  const std::vector<Measured> values = sumRows(entries, ids.areas), counted_rows = counted.measureRows(measure_area);
  // Entries that the same directions counted do not err independently, so their row sums have a spread of their own.
  for (size_t k = 0; k < rows.size(); ++k)
    rows[k] = {values[k].value, std::hypot(rows[k].standard_error, counted_rows[k].standard_error)};
  return {ids, std::move(entries), std::move(rows)};
}

FormFactors lineFormFactors(std::vector<FormFactors::Entry> entries, const std::vector<uint32_t>& surface, By by,
                            const ReplicateSums& counted, double measure_area, double count_area) {
  const Ids& ids = counted.ids();
  if (by == By::surface) entries = mergeBySurface(std::move(entries), surface);
  if (ids.counts_environment) addEnvironmentAndLeak(entries, counted, measure_area, count_area);
  std::vector<Measured> rows = sumRows(entries, ids.areas);
  return {ids, std::move(entries), std::move(rows)};
}

}  // namespace viewpeel
