#include "sums/line_form_factors.h"

#include <algorithm>
#include <cmath>

#include "sums/add_pairs.h"
#include "sums/mixture_entries.h"
#include "sums/row_sums.h"

namespace viewpeel {
namespace {

// In a closed scene the pairs of a row never leave this share of it unless the row has a leak.
constexpr double kSurelyLeft = 0.05;

// Merges the entries between surfaces of the pairs that common directions counted into those of the pairs with lines.
void addCounted(std::vector<FormFactors::Entry>& entries, const ReplicateSums& counted, double measure_area,
                double count_area) {
  const auto with_lines = static_cast<std::ptrdiff_t>(entries.size());
  for (const ReplicateSums::PairSum& pair : counted.pairs())
    entries.push_back({pair.i, pair.j, counted.exchangeArea(pair, measure_area, count_area)});
  std::ranges::inplace_merge(entries, entries.begin() + with_lines, {}, keyOf<FormFactors::Entry>);
  addSameKeys(entries);
}

// Adds the spread of counted row sums to the errors of row sums. Entries that the same directions counted do not err
// independently, so their row sums have a spread of their own.
void addErrorsOfCounts(std::vector<Measured>& rows, const std::vector<Measured>& counted_rows) {
  for (size_t k = 0; k < rows.size(); ++k)
    rows[k].standard_error = std::hypot(rows[k].standard_error, counted_rows[k].standard_error);
}

// Returns the form factors of a mixture between polygons.
FormFactors mixtureByPolygon(const LineSums& lines, const ReplicateSums& counted, double measure_area,
                             double count_area) {
  const MixtureEntries mixture(lines, counted, measure_area, count_area);
  const LineSums::ChanceFactors factors = lines.chanceFactors();
  std::vector<FormFactors::Entry> entries(mixture.count());
  std::vector<char> has_lines(mixture.count());
  mixture.forEach(
      [&](size_t, size_t place, size_t pair) {
        entries[place] = lines.entryAt(pair, factors);
        has_lines[place] = true;
      },
      [&](size_t, size_t place, const FormFactors::Entry& entry) { entries[place] = entry; });
  const Ids& ids = counted.ids();
  const RowTotals totals = sumByRow(entries.size(), ids.count(), [&](size_t k, RowTotals& of_part) {
    addToRows(of_part[0], entries[k], entries[k].exchange_area.value);
    if (has_lines[k]) addToRows(of_part[1], entries[k], entries[k].errorInSums() * entries[k].errorInSums());
  });
  std::vector<Measured> rows = rowSumsOf(totals, ids.areas);
  addErrorsOfCounts(rows, counted.measureRows(measure_area));
  return {ids, std::move(entries), std::move(rows)};
}

// Returns the mean of least variance of what common directions say that a row leaks, and of 0 +- `error`, as its rays
// say. Its error stays that of the rays, for a leak that few directions saw has a spread of little worth.
Measured afterRays(const Measured& leak, double error) {
  const double ratio = leak.standard_error / error;
  return {leak.value / (1 + ratio * ratio), error};
}

// Adds entries of the environment to the rows that see it, and entries of leak that only common directions have
// counted. Such a leak is small, or it would have lines. So its error is its spread over replicates, without the part
// of eq. (12) that allows for what no direction saw. Where parts of a scene are far from each other, all common lines
// may pass them by. So a scene counts as open, too, if the form factors of a row surely add up to less than
// 1 - kSurelyLeft.
// If rays from a row ended on no back, its leak is 0 with one ray's share as the standard error.
//   In: leaking: of rows
void addEnvironmentAndLeak(std::vector<FormFactors::Entry>& entries, const ReplicateSums& counted, double measure_area,
                           const LeakingFaces& leaking) {
  const Ids& ids = counted.ids();
  std::vector<Measured> environment(ids.count()), leak(ids.count());
  bool is_open = false;
  for (uint32_t i = 0; i < ids.count() && leaking.rays > 0; ++i)
    if (!leaking.of_face[i]) leak[i].standard_error = ids.areas[i] / leaking.rays;
  for (const ReplicateSums::PairSum& pair : counted.pairs()) {
    if (pair.j < kEnvironment) continue;
    is_open |= pair.j == kEnvironment;
    const Measured area = counted.exchangeArea(pair, measure_area, INFINITY);
    Measured& of_leak = leak[pair.i];
    if (pair.j == kEnvironment) environment[pair.i] = area;
    else of_leak = of_leak.standard_error > 0 ? afterRays(area, of_leak.standard_error) : area;
  }
  for (const FormFactors::Entry& entry : entries)
    if (entry.j == kLeak) leak[entry.i] = {};  // the entries have this leak already
  const std::vector<Measured> rows = sumRows(entries, ids.areas);
  const std::vector<double> margins = largestMargins(entries, ids.count());
  std::vector<double> left(ids.count());  // of each row's area, for the environment
  for (uint32_t i = 0; i < ids.count(); ++i) {
    const double beside_pairs = std::max(0.0, 1 - rows[i].value) * ids.areas[i];
    leak[i] = {std::min(leak[i].value, beside_pairs), std::min(leak[i].standard_error, beside_pairs)};
    left[i] = beside_pairs - leak[i].value;
    const double sure = std::max(kSurelyLeft, kBeyondDoubt * rows[i].standard_error);
    is_open |= ids.rows_sum_to_one && ids.isRequested(i) && left[i] > sure * ids.areas[i];
  }
  const auto pair_count = static_cast<std::ptrdiff_t>(entries.size());
  for (uint32_t i = 0; i < ids.count(); ++i) {
    if (!ids.isRequested(i)) continue;
    const double doubt = rows[i].standard_error * ids.areas[i];
    if (environment[i].value > 0 || (is_open && left[i] > kBeyondDoubt * doubt))
      entries.push_back({i, kEnvironment, {left[i], std::hypot(doubt, std::sqrt(margins[i]), leak[i].standard_error)}});
    if (leak[i].value > 0) entries.push_back({i, kLeak, leak[i]});
  }
  std::ranges::inplace_merge(entries, entries.begin() + pair_count, {}, keyOf<FormFactors::Entry>);
}

}  // namespace

std::vector<double> largestMargins(const std::vector<FormFactors::Entry>& entries, size_t row_count) {
  std::vector<double> margins(row_count);
  for (const FormFactors::Entry& entry : entries)
    for (const uint32_t id : {entry.i, entry.j})
      if (id < row_count) margins[id] = std::max(margins[id], entry.margin());
  return margins;
}

std::vector<bool> leakingSurfaces(const std::vector<bool>& of_face, const std::vector<uint32_t>& surface,
                                  size_t surfaces) {
  std::vector<bool> of_surface(surfaces);
  for (size_t face = 0; face < of_face.size(); ++face)
    if (of_face[face]) of_surface[surface[face]] = true;
  return of_surface;
}

FormFactors lineFormFactors(const LineSums& lines, By by, const ReplicateSums& counted, double measure_area,
                            double count_area) {
  if (lines.leastFormFactor() == 0) {
    const std::vector<uint32_t>& surface = lines.ids().surface;
    LeakingFaces leaking = lines.leakingFaces();
    if (by == By::surface) leaking.of_face = leakingSurfaces(leaking.of_face, surface, counted.ids().count());
    return lineFormFactors(lines.entries(), surface, by, counted, measure_area, leaking);
  }
  if (by == By::polygon) return mixtureByPolygon(lines, counted, measure_area, count_area);
  const Ids& ids = counted.ids();
  std::vector<FormFactors::Entry> entries = mergeBySurface(lines.entries(), lines.ids().surface);
  std::vector<Measured> rows = sumRows(entries, ids.areas);
  addCounted(entries, counted, measure_area, count_area);
  const std::vector<Measured> values = sumRows(entries, ids.areas);
  for (size_t k = 0; k < rows.size(); ++k) rows[k].value = values[k].value;
  addErrorsOfCounts(rows, counted.measureRows(measure_area));
  return {ids, std::move(entries), std::move(rows)};
}

FormFactors lineFormFactors(std::vector<FormFactors::Entry> entries, const std::vector<uint32_t>& surface, By by,
                            const ReplicateSums& counted, double measure_area, const LeakingFaces& leaking) {
  const Ids& ids = counted.ids();
  if (by == By::surface) entries = mergeBySurface(std::move(entries), surface);
  if (ids.counts_environment) addEnvironmentAndLeak(entries, counted, measure_area, leaking);
  std::vector<Measured> rows = sumRows(entries, ids.areas);
  return {ids, std::move(entries), std::move(rows)};
}

}  // namespace viewpeel
