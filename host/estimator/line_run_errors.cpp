// This file measures the errors of a LineRun, and plans the next replicate where they miss the goal.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/line_run.h"
#include "estimator/plan_rays.h"
#include "estimator/plan_rays_for_rms.h"
#include "memory.h"
#include "rays/ray_engine.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "sums/mixture_entries.h"
#include "sums/pair_walk.h"
#include "sums/row_sums.h"

namespace viewpeel {
namespace {

using Key = std::pair<uint32_t, uint32_t>;

// Lines drawn, over the lines that an error asks for: in the first further replicate, and in later ones. Few pairs need
// lines then, and drawing more of them takes less time than measuring all errors once more.
constexpr double kSpare = 1.2, kLaterSpare = 2;
constexpr double kMostGrowth = 16;   // of a pair's lines, by one replicate
constexpr double kMostTimes = 1000;  // most multiples of planned lines, so that LineCount's units suffice
// Before errors are measured again, a row gets rays in at most this number of further replicates.
constexpr double kMostFurtherRays = 16;

}  // namespace

// Returns an entry's error over the error that the goals allow.
double LineRun::excessOf(const FormFactors::Entry& entry, const Ids& ids) const {
  const double area = ids.smallerArea(entry.i, entry.j),
               error = errors_in_goal_.of(entry.j) * entry.exchange_area.standard_error;
  return error / (options_.allowedError(entry.exchange_area.value / area) * area);
}

// The same of an entry that rays or common directions count, not lines.
double LineRun::excessOfCounts(const FormFactors::Entry& entry, const Ids& ids) const {
  return (hasFurtherRays() ? kRayMargin : 1) * excessOf(entry, ids);
}

// Returns by row whether lines, and not common directions or rays, say what ends on backs.
std::vector<bool> LineRun::findLeaksByLines() const {
  std::vector<bool> by_lines(sumsOfRows().ids().count());
  for (size_t k = 0; k < sums_.lines->pairs().size(); ++k)
    if (sums_.lines->hasBack(k))
      by_lines[entryOf(sums_.lines->pairs()[k], sums_.lines->ids(), options_.by).first] = true;
  return by_lines;
}

// Returns the error of each row's environment over the error that the goals allow; 0 where the row has none. A row's
// environment is 1 less its pairs, so their variances add up.
//   In: leak_by_lines: from findLeaksByLines()
std::vector<double> LineRun::findRowExcess(const FormFactors& all, const std::vector<bool>& leak_by_lines) const {
  const Ids& ids = all.ids();
  std::vector<double> variances(ids.count()), excess(ids.count());
  for (const FormFactors::Entry& entry : all.entries())
    for (const uint32_t id : {entry.i, entry.j})
      if (id < kEnvironment && (entry.j < kEnvironment || (entry.j == kLeak && leak_by_lines[id])))
        variances[id] += std::pow(entry.errorInSums(), 2);
  const std::vector<double> margins = largestMargins(all.entries(), ids.count());
  std::vector<bool> has_environment(ids.count());
  bool is_open = false;
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j != kEnvironment) continue;
    is_open = has_environment[entry.i] = true;
    const double error = std::sqrt(variances[entry.i] + margins[entry.i]);
    excess[entry.i] = excessOf({entry.i, kEnvironment, {entry.exchange_area.value, error}}, ids);
  }
  // In an open scene another row may see the environment, too, where its pairs leave something of it. It gets an
  // environment if that is more than kBeyondDoubt standard errors, which therefore must be within the tolerance.
  for (uint32_t id = 0; is_open && options_.tolerance && id < ids.count(); ++id)
    if (ids.isRequested(id) && !has_environment[id] && all.rowSums()[id].value < 1)
      excess[id] = kBeyondDoubt * std::sqrt(variances[id]) / (*options_.tolerance * ids.areas[id]);
  return excess;
}

// Returns the error of all lines of each row over the error that the tolerance allows its sum, in a mixture with rays;
// else nothing.
std::vector<double> LineRun::findRowExcessOfLines() const {
  if (!options_.rays || !options_.tolerance) return {};
  const LineSums& lines = *sums_.lines;
  const Ids& ids = lines.ids();
  const LineSums::ChanceFactors factors = lines.chanceFactors();
  std::vector<double> excess = sumByRow(lines.pairs().size(), ids.count(), [&](size_t k, RowTotals& variances) {
    const FormFactors::Entry entry = lines.entryAt(k, factors);
    addToRows(variances[0], entry, entry.errorInSums() * entry.errorInSums());
  })[0];
  for (uint32_t i = 0; i < ids.count(); ++i)
    excess[i] = errors_in_goal_.of(kEnvironment) * std::sqrt(excess[i]) / (*options_.tolerance * ids.areas[i]);
  return excess;
}

// Plans further rays of this row.    In: excess: error of its environment or leak, over the error that the goals allow
void LineRun::planFurtherRays(uint32_t row, double excess) {
  // Variances fall as the number of replicates. Half of the missing ones come next, for the error is rough.
  const double missing = double(sumsOfRows().replicatesOf(row, kEnvironment)) * (excess * excess - 1) / 2;
  further_rays_[row] = std::max(further_rays_[row], static_cast<uint32_t>(std::clamp(missing, 1.0, kMostFurtherRays)));
  needs_directions_ = true;
}

// Plans further rays, or common directions, for the rows whose leak misses the goal and has no lines.
//   In: leak_by_lines: from findLeaksByLines()
void LineRun::planFurtherCountsOfLeaks(const FormFactors& all, const std::vector<bool>& leak_by_lines) {
  needs_directions_ = false;
  further_rays_.assign(all.ids().count(), 0);
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j != kLeak || leak_by_lines[entry.i]) continue;
    const double excess = excessOfCounts(entry, all.ids());
    if (excess > 1 && hasFurtherRays()) planFurtherRays(entry.i, excess);
    else needs_directions_ |= excess > 1;
  }
}

void LineRun::measureErrors() {
  if (sums_.replicateCount() < options_.replicates) return;
  if (hasCountedPairs() && options_.by == By::polygon) return measureErrorsOfMixture();
  std::optional<FormFactors> all = sums_.formFactors();
  largest_error_ = viewpeel::largestStandardError(*all);
  if (hasCountedPairs()) {
    const Wanting wanting = findWantingBetweenSurfaces(*all);
    planFurther(excessOfPairs(wanting, {}), 1);
    noteErrorsBesideLines(wanting);
  } else if (options_.rms)
    planFurtherInTime(
        std::vector(sums_.lines->pairs().size(), measureStandardErrors(*all, 0).rms_with_zeros / *options_.rms));
  else {
    const std::vector<bool> leak_by_lines = findLeaksByLines();
    planFurtherCountsOfLeaks(*all, leak_by_lines);
    const Wanting wanting = findWanting(*all);
    planFurtherInTime(excessOfPairs(wanting, findRowExcess(*all, leak_by_lines)));
    noteErrorsBesideLines(wanting);
  }
  const bool is_large = all->entries().size() > kLargeList;
  all.reset();
  if (is_large) returnFreedMemory();
}

// Returns the entries whose lines are too few for the goals, sorted, and their errors over the errors allowed.
LineRun::Wanting LineRun::findWanting(const FormFactors& all) const {
  Wanting wanting;
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j == kEnvironment) continue;
    const double excess = excessOf(entry, all.ids());
    if (excess > 1) wanting.emplace_back(keyOf(entry), excess);
  }
  return wanting;
}

// As measureErrors(), of a mixture between polygons. An entry's error is due to lines or to counts alone. Counted pairs
// of polygons are within the goal whatever their counts (kMostOfCounted).
void LineRun::measureErrorsOfMixture() {
  const Ids& ids = sums_.by_id.ids();
  const MixtureEntries mixture(*sums_.lines, sums_.by_id, sums_.measure_area, sums_.countArea());
  std::optional<LineSums::ChanceFactors> factors;  // where errors in sums are wanted
  if (options_.rms) factors = sums_.lines->chanceFactors();
  struct alignas(64) Found {  // threads write to different lines of the processor's caches
    double largest_error = 0;
    double squares_of_lines = 0, squares_of_counts = 0;  // of errors between polygons
    std::vector<std::pair<uint32_t, double>> rows;  // whose environment or leak misses the goal, and by which factor
    Wanting wanting;
  };
  std::vector<Found> found(mixture.sliceCount());
  const auto noteError = [&](Found& of, double& squares, const FormFactors::Entry& entry) {
    if (entry.j < kEnvironment)
      for (const uint32_t id : {entry.i, entry.j}) squares += std::pow(entry.errorInSums() / ids.areas[id], 2);
    of.largest_error =
        std::max(of.largest_error, entry.exchange_area.standard_error / ids.smallerArea(entry.i, entry.j));
  };
  mixture.forEach(
      [&](size_t slice, size_t, size_t pair) {
        const LinePair& of = sums_.lines->pairs()[pair];
        const FormFactors::Entry entry = factors ? sums_.lines->entryAt(pair, *factors)
                                                 : FormFactors::Entry{of.i, of.j, sums_.lines->exchangeArea(pair)};
        noteError(found[slice], found[slice].squares_of_lines, entry);
        if (const double excess = excessOf(entry, ids); excess > 1)
          found[slice].wanting.emplace_back(keyOf(entry), excess);
      },
      [&](size_t slice, size_t, const FormFactors::Entry& entry) {
        noteError(found[slice], found[slice].squares_of_counts, entry);
        if (entry.j < kEnvironment) return;
        const double excess = excessOfCounts(entry, ids);
        if (excess > 1) found[slice].rows.emplace_back(entry.i, excess);
      });
  largest_error_ = 0;
  needs_directions_ = false;
  further_rays_.assign(ids.count(), 0);
  Wanting wanting;
  double squares_of_lines = 0, squares_of_counts = 0;
  for (const Found& of : found) {
    squares_of_lines += of.squares_of_lines, squares_of_counts += of.squares_of_counts;
    largest_error_ = std::max(largest_error_, of.largest_error);
    for (const auto& [row, excess] : of.rows) planFurtherRays(row, excess);
    wanting.insert(wanting.end(), of.wanting.begin(), of.wanting.end());
  }
  if (options_.rms) planFurtherForRms(squares_of_lines, squares_of_counts);
  else planFurther(excessOfPairs(wanting, findRowExcessOfLines()), 1);
  noteErrorsBesideLines(wanting);
}

// Notes that the goal is missed where an entry of pairs that nothing can block errs by more than the goal: no lines
// reduce the error of its unoccluded form factor. That error is a bound, and so it may be as large as the goal.
void LineRun::noteErrorsBesideLines(const Wanting& wanting) {
  if (std::ranges::any_of(wanting, [](const auto& entry) { return entry.second > kErrorsInGoal; })) is_reached_ = false;
}

// Plans the next replicate of a mixture whose goal is the root mean square of all errors.
//   In: of_lines, of_counts: sums of squares of errors
void LineRun::planFurtherForRms(double of_lines, double of_counts) {
  const double allowed = std::pow(*options_.rms * double(sums_.by_id.ids().count()), 2);
  const bool is_reached = of_lines + of_counts <= allowed;
  needs_directions_ = !is_reached && of_counts > (1 - kLinesOfSquares) * allowed;
  const double excess = is_reached ? 0 : std::sqrt(of_lines / (kLinesOfSquares * allowed));
  planFurther(std::vector(sums_.lines->pairs().size(), excess), 1);
}

// Returns the entries between surfaces whose lines are too few, as findWanting(), where common directions have counted
// some pairs. Further lines reduce only the part of an entry's error that is due to lines.
//   Out: needs_directions_: whether the part due to common directions is too large for an entry
LineRun::Wanting LineRun::findWantingBetweenSurfaces(const FormFactors& all) {
  const std::vector<FormFactors::Entry> of_lines = sums_.lines->entriesOfResult();
  Wanting wanting;
  needs_directions_ = false;
  PairWalk walk(of_lines);
  for (const FormFactors::Entry& entry : all.entries()) {
    const double excess = excessOf(entry, all.ids());
    if (!(excess > 1)) continue;
    const FormFactors::Entry* const line = walk.find(entry);
    const double by_lines = line ? line->exchange_area.standard_error : 0, whole = entry.exchange_area.standard_error,
                 allowed = whole / excess, by_counts = std::sqrt(std::max(0.0, whole * whole - by_lines * by_lines));
    if (line && by_counts < allowed)
      wanting.emplace_back(keyOf(entry), by_lines / std::sqrt(allowed * allowed - by_counts * by_counts));
    else needs_directions_ = true;
  }
  return wanting;
}

// Returns each pair's error over the error that its entry and its rows allow; 0 where none of them wants lines, and
// nothing where no pair does. All pairs of a wanting row get more lines in one proportion. If instead the pairs with
// the largest errors got them, sums would be too small: a pair of which no line was clear seems certain, and would keep
// its 0, while pairs that have had a clear line by chance would lose what they are above their expectation.
//   In: row_excess: from findRowExcess() or findRowExcessOfLines(), or empty
std::vector<double> LineRun::excessOfPairs(const Wanting& wanting, const std::vector<double>& row_excess) const {
  if (wanting.empty() && std::ranges::none_of(row_excess, [](double row) { return row > 1; })) return {};
  const std::vector<LinePair>& pairs = sums_.lines->pairs();
  std::vector<double> all(pairs.size());
  for (size_t k = 0; k < all.size(); ++k) {
    if (pairs[k].blocks == 0) continue;
    const Key key = entryOf(pairs[k], sums_.lines->ids(), options_.by);
    const auto at = std::ranges::lower_bound(wanting, key, {}, &std::pair<Key, double>::first);
    if (at != wanting.end() && at->first == key) all[k] = at->second;
    for (const uint32_t id : {key.first, key.second})
      if (id < row_excess.size()) all[k] = std::max(all[k], row_excess[id]);
  }
  return all;
}

// Plans the next replicate: lines that bring the wanting entries and rows to the goal, and common directions or rays if
// an entry needs them.
//   In: excess: from excessOfPairs(); relief: goals are this much coarser
void LineRun::planFurther(const std::vector<double>& excess, double relief) {
  const std::vector<LinePair>& pairs = sums_.lines->pairs();
  further_.assign(excess.size(), 0);
  is_reached_ = std::ranges::none_of(excess, [](double of_pair) { return of_pair > 1; });
  const double spare = sums_.replicateCount() > options_.replicates ? kLaterSpare : kSpare;
  bool is_wanting = false;
  for (size_t k = 0; k < further_.size(); ++k) {
    if (!(excess[k] > relief) || pairs[k].blocks == 0) continue;
    // The number of lines is proportional to the error to the power of -8/5. kMostGrowth limits it, because an error
    // from few lines is rough.
    const double lines = std::min(spare * std::pow(excess[k] / relief, 8.0 / 5), kMostGrowth) - 1,
                 times = lines * double(sums_.lines->sumOf(k).blocks) / pairs[k].blocks;
    further_[k] = static_cast<uint32_t>(std::clamp(std::ceil(times), 1.0, kMostTimes));
    is_wanting = true;
  }
  if (!is_wanting) further_.clear();
  const bool may_go_on = mayGoOn();
  if (!may_go_on) further_.clear();
  is_further_ = !further_.empty();
  if (!needs_directions_) return;
  is_reached_ = false;
  if (!may_go_on || double(sums_.by_id.pairs().size()) >= kMostCountedPairs) return;
  further_.resize(pairs.size(), 0);
  is_further_ = true;
}

// Plans the next replicate as planFurther(). Where it would not end before the time limit, the lines are those of the
// finest goals for which it takes half of the time that is left. Where the time is the goal, it never takes more.
void LineRun::planFurtherInTime(const std::vector<double>& excess) {
  constexpr double kLeastPart = 0.1;  // of the time so far: a shorter replicate would improve little
  constexpr int kHalvings = 8;
  planFurther(excess, 1);
  if (!is_further_ || !options_.seconds) return;
  const double left = secondsLeft(), most = left / 2;
  if (secondsOfNext() <= (options_.is_timed ? most : left)) return;
  double fitting = std::ranges::max(excess), not_fitting = 1;  // reliefs: with the first one no pair gets lines
  for (int k = 0; k < kHalvings && most > kLeastPart * secondsSince(start_); ++k) {
    const double middle = std::sqrt(fitting * not_fitting);
    planFurther(excess, middle);
    (!is_further_ || secondsOfNext() <= most ? fitting : not_fitting) = middle;
  }
  planFurther(excess, fitting);
}

}  // namespace viewpeel
