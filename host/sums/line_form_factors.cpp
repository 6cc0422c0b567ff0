#include "sums/line_form_factors.h"

#include <algorithm>
#include <cmath>

#include "sums/add_pairs.h"
#include "sums/calibrate_rows.h"

namespace viewpeel {
namespace {

// A row that lacks more than this number of standard errors surely sees the environment.
constexpr double kBeyondDoubt = 3;

// Returns entries between surfaces: sums of the entries between their faces, whose errors are independent.
std::vector<FormFactors::Entry> mergeBySurface(std::vector<FormFactors::Entry> entries,
                                               const std::vector<uint32_t>& surface) {
  for (FormFactors::Entry& entry : entries) {
    const auto [i, j] = std::minmax({surface[entry.i], entry.j < kEnvironment ? surface[entry.j] : entry.j});
    // A surface's exchange with itself has each pair of its faces twice, once in either direction.
    const double ways = i == j ? 2 : 1;
    entry = {i, j, {ways * entry.exchange_area.value, ways * entry.exchange_area.standard_error}};
  }
  std::ranges::sort(entries, {}, keyOf<FormFactors::Entry>);
  std::vector<FormFactors::Entry> merged;
  for (const FormFactors::Entry& entry : entries) {
    if (merged.empty() || keyOf(merged.back()) != keyOf(entry)) {
      merged.push_back(entry);
      continue;
    }
    Measured& sum = merged.back().exchange_area;
    sum.value += entry.exchange_area.value;
    sum.standard_error = std::hypot(sum.standard_error, entry.exchange_area.standard_error);
  }
  return merged;
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
  return lineFormFactors(lines.entries(), lines.ids().surface, by, counted, measure_area, count_area);
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
