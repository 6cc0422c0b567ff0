#include "estimator/line_guarantee.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/chernoff.h"
#include "estimator/estimate.h"
#include "stopwatch.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr uint32_t kMostEntryLooks = 5;  // at an entry's bound; each has twice the lines of the one before
constexpr double kFewestLines = 16;      // of an entry
// Of unoccluded form factors (kUnoccludedRelativeError), and of the density of lines.
constexpr double kRoundingError = 3e-6;
constexpr double kLeastRoundingShare = 0.5;  // of epsilon that rounding has to leave
constexpr double kShareOfLines = 0.98;    // of what an entry may err; the rest is for lines that rounding leaves open
constexpr double kShareOfRowLines = 0.9;  // the same of a row, with parts that cost too many candidates
constexpr double kFirstLook = 1.2;        // of the lines after which an entry without facing lines is done
constexpr double kRowShare = 0.5;         // of delta, where rows have bounds
constexpr uint64_t kPilotSeries = 1000;   // looks have those below
// A line of an entry that geometry bounds may cost so many candidates; beyond, its lines are left open. Such entries
// are small and near: slivers side by side. Where a row's sum is promised, or is the entry, each of them counts more.
constexpr double kMostCandidates = 100, kMostCandidatesOfSums = 10'000;
constexpr double kShareOfOpen = 0.01;  // of what a sum may err: parts that may be left open sooner, all together
constexpr size_t kChunk = 16;          // entries that a thread takes at once
constexpr size_t kTimedEntries = 64;
constexpr uint64_t kTimedLines = 2048;

// Returns the largest weight c of a line for which Hoeffding's bound is `allowed`, where parts of g = blockable in all
// have ceil(g_k / c) lines: c^2 (g / c + parts) l / 2 <= allowed^2.
double hoeffdingWeight(double blockable, double parts, double allowed, double l) {
  return (std::sqrt(blockable * blockable + 8 * parts * allowed * allowed / l) - blockable) / (2 * parts);
}

double linesOfPart(double exchange, double weight) { return std::max(1.0, std::ceil(exchange / weight)); }

}  // namespace

LineGuarantee::LineGuarantee(const Scene& scene, const Ids& face_ids, const Ids& ids, PairLines& lines,
                             const LineGuaranteeOptions& options)
    : scene_(scene), face_ids_(face_ids), ids_(ids), lines_(lines), options_(options) {
  const auto begun = Clock::now();
  options_.rows &= options_.delta > 0;  // no number of lines proves a row's sum for certain
  collectEntries();
  if (lines_.hasTooMany()) return;
  planLooks();
  if (options_.rows) planRows();
  predict();
  open_.resize(entries_.size());
  std::iota(open_.begin(), open_.end(), 0u);
  // The entries with most lines first, so that no thread is left with one of them at the end.
  std::ranges::stable_sort(open_, std::ranges::greater{},
                           [&](uint32_t k) { return linesOf(entries_[k], entries_[k].looks - 1); });
  const double e = options_.epsilon, d = options_.delta, bounds = double(std::max<size_t>(entries_.size(), 1));
  figures_.epsilon = e, figures_.delta = d;
  figures_.lemma_1 = 1 / (e * e * d), figures_.lemma_1_all = bounds / (e * e * d);
  figures_.median_directions = std::ceil(8 * std::log(bounds / d)) * 4 / (e * e);
  figures_.plan_seconds = secondsSince(begun);
}

void LineGuarantee::collectEntries() {
  const std::vector<LinePair> pairs = lines_.find();
  std::vector<std::pair<std::pair<uint32_t, uint32_t>, uint32_t>> by_key;
  by_key.reserve(pairs.size());
  for (uint32_t k = 0; k < pairs.size(); ++k) by_key.push_back({entryOf(pairs[k], face_ids_, options_.by), k});
  std::ranges::sort(by_key);
  for (const auto& [key, k] : by_key) {
    if (entries_.empty() || keyOf(entries_.back()) != key) {
      entries_.push_back({key.first, key.second});
      entries_.back().first_part = static_cast<uint32_t>(parts_.size());
    }
    // Two faces of one surface exchange both ways within it.
    const double ways = key.first == key.second ? 2 : 1;
    Entry& entry = entries_.back();
    entry.exchange += ways * pairs[k].exchange, entry.clear += ways * pairs[k].clear;
    for (const PairLines::Part& part : lines_.blockableParts(k)) parts_.push_back({part.index, ways * part.exchange});
    entry.part_count = static_cast<uint32_t>(parts_.size()) - entry.first_part;
  }
  for (Entry& entry : entries_) {
    double blockable = 0;
    for (uint32_t k = 0; k < entry.part_count; ++k) blockable += parts_[entry.first_part + k].exchange;
    entry.clear = entry.exchange - blockable;
    const double area = ids_.smallerArea(entry.i, entry.j);
    entry.allowed = options_.epsilon * area - kRoundingError * entry.exchange;
    if (entry.allowed < kLeastRoundingShare * options_.epsilon * area)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("--epsilon {} is below what rounding leaves of a guarantee; ask for {:.0e} or more",
                              options_.epsilon, kRoundingError / (1 - kLeastRoundingShare)));
    if (entry.j == kLeak && !options_.rows) entry.allowed = INFINITY;  // a part of the row's sum, like environment
  }
}

void LineGuarantee::planLooks() {
  const auto isDrawn = [&](const Entry& entry) { return options_.delta > 0 && !entry.isBounded(); };
  const bool has_rows = ids_.counts_environment && options_.delta > 0;
  const double drawn = double(std::ranges::count_if(entries_, isDrawn)),
               delta = options_.delta * (has_rows ? 1 - kRowShare : 1);
  log_entry_ = std::log(2 * std::max(drawn, 1.0) * kMostEntryLooks / delta);
  log_row_ = std::log(2 * double(ids_.count()) / (kRowShare * options_.delta));
  for (Entry& entry : entries_) {
    const double blockable = entry.blockable();
    ++(entry.part_count == 0 ? figures_.exact : isDrawn(entry) ? figures_.drawn : figures_.bounded);
    if (entry.part_count == 0) continue;
    entry.weight = blockable / kFewestLines;
    if (entry.j == kLeak && !options_.rows) {
      // So many lines that its standard error is epsilon at most.
      const double allowed = options_.epsilon * ids_.areas[entry.i];
      entry.weight = std::min(entry.weight, 4 * allowed * allowed / blockable);
    }
    if (!isDrawn(entry)) {
      entry.most_candidates = entry.j == kLeak ? kMostCandidatesOfSums : kMostCandidates;
      continue;
    }
    const double allowed = kShareOfLines * entry.allowed,
                 last = std::min(entry.weight, hoeffdingWeight(blockable, entry.part_count, allowed, log_entry_)),
                 first = std::max(last, std::min(entry.weight, allowed / (kFirstLook * log_entry_)));
    entry.weight = last;
    entry.looks = std::min(kMostEntryLooks, 1 + static_cast<uint32_t>(std::log2(first / last)));
  }
}

// Lines of the first look bound a row's sum: so many that the bound is epsilon.
void LineGuarantee::planRows() {
  std::vector<double> blockable(ids_.count(), 0), parts(ids_.count(), 0), rounding(ids_.count(), 0),
      entry_counts(ids_.count(), 0);
  const auto addTo = [&](uint32_t row, const Entry& entry) {
    blockable[row] += entry.blockable(), parts[row] += entry.part_count;
    rounding[row] += kRoundingError * entry.exchange;
    ++entry_counts[row];
  };
  const auto forRows = [&](const Entry& entry, const auto& use) {
    if (ids_.isRequested(entry.i)) use(entry.i);
    if (entry.j < kEnvironment && entry.j != entry.i && ids_.isRequested(entry.j)) use(entry.j);
  };
  for (const Entry& entry : entries_) forRows(entry, [&](uint32_t row) { addTo(row, entry); });
  for (Entry& entry : entries_) {
    if (entry.part_count == 0) continue;
    double most = INFINITY;
    forRows(entry, [&](uint32_t row) {
      const double allowed = kShareOfRowLines * options_.epsilon * ids_.areas[row] - rounding[row];
      most = std::min(most, hoeffdingWeight(blockable[row], parts[row], allowed, log_row_));
      if (entry.blockable() * entry_counts[row] > kShareOfOpen * options_.epsilon * ids_.areas[row])
        entry.most_candidates = std::max(entry.most_candidates, kMostCandidatesOfSums);
    });
    entry.weight = std::min(entry.weight, most);
    while (entry.looks > 1 && weightAt(entry, 0) > most) --entry.looks;
  }
}

// A pilot of some lines predicts after which look an entry will be done.
void LineGuarantee::predict() {
  const auto expectedLines = [&](const Entry& entry) {
    double facing = 0, all = 0;
    for (uint32_t k = 0; k < entry.part_count; ++k) {
      const Part& part = parts_[entry.first_part + k];
      const uint64_t lines = k < kFewestLines ? static_cast<uint64_t>(kFewestLines) / entry.part_count + 1 : 0;
      const UniformLineCount count =
          lines_.drawUniform(part.index, kPilotSeries, lines, mostCandidates(entry, part), vectors_);
      facing += double(count.facing), all += double(count.lines);
    }
    const double share = (facing + 1) / (all + 2), variance = share * (1 - share);
    for (uint32_t look = 0; look + 1 < entry.looks; ++look) {
      const double n = linesOf(entry, look),
                   bound = entry.blockable() * (std::sqrt(2 * variance * log_entry_ / n) + log_entry_ / (3 * n));
      if (bound <= entry.allowed) return n;
    }
    return linesOf(entry, entry.looks - 1);
  };
  std::vector<double> expected(entries_.size(), 0);
  forEach(entries_.size(), [&](size_t k) {
    const Entry& entry = entries_[k];
    if (entry.part_count) expected[k] = entry.looks > 1 ? expectedLines(entry) : linesOf(entry, 0);
  });
  std::vector<uint32_t> drawn;
  for (uint32_t k = 0; k < entries_.size(); ++k) {
    if (entries_[k].part_count == 0) continue;
    figures_.expected_lines += expected[k];
    figures_.most_lines += linesOf(entries_[k], entries_[k].looks - 1);
    drawn.push_back(k);
    most_looks_ = std::max(most_looks_, entries_[k].looks);
  }
  figures_.most_for_one = 0;
  for (const Entry& entry : entries_)
    if (const double lines = entry.part_count ? linesOf(entry, entry.looks - 1) : 0; lines > figures_.most_for_one)
      figures_.most_for_one = lines, figures_.neediest = {ids_.names[entry.i], nameOf(entry.j)};
  if (drawn.empty()) return;
  const auto begun = Clock::now();
  // Those with most lines take most of the time.
  const size_t timed = std::min(kTimedEntries, drawn.size());
  std::ranges::partial_sort(drawn, drawn.begin() + static_cast<std::ptrdiff_t>(timed), std::ranges::greater{},
                            [&](uint32_t k) { return expected[k]; });
  for (size_t k = 0; k < timed; ++k)
    lines_.drawUniform(parts_[entries_[drawn[k]].first_part].index, kPilotSeries, kTimedLines, kMostCandidates,
                       vectors_);
  const double seconds_each = secondsSince(begun) / double(timed * kTimedLines) / double(lines_.threads());
  figures_.expected_seconds = figures_.expected_lines * seconds_each;
  figures_.most_seconds = figures_.most_lines * seconds_each;
}

void LineGuarantee::forEach(size_t count, const std::function<void(size_t)>& work) const {
  shareOut(
      lines_.threads(), count, kChunk, [&](size_t, size_t k) { work(k); }, [&](size_t) { lines_.stopIfRequested(); });
}

double LineGuarantee::weightAt(const Entry& entry, uint32_t look) const {
  return std::ldexp(entry.weight, static_cast<int>(entry.looks - 1 - look));
}

double LineGuarantee::linesOf(const Entry& entry, uint32_t look) const {
  double lines = 0;
  for (uint32_t k = 0; k < entry.part_count; ++k)
    lines += linesOfPart(parts_[entry.first_part + k].exchange, weightAt(entry, look));
  return lines;
}

// Returns how many candidates a line of a part may cost. Little parts of a sum may be left open.
double LineGuarantee::mostCandidates(const Entry& entry, const Part& part) const {
  const bool is_little = part.exchange * entry.part_count <= kShareOfOpen * entry.allowed;
  return is_little ? std::min(entry.most_candidates, kMostCandidates) : entry.most_candidates;
}

void LineGuarantee::draw(Entry& entry, uint32_t look) {
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    Part& part = parts_[entry.first_part + k];
    const auto wanted = static_cast<uint64_t>(linesOfPart(part.exchange, weightAt(entry, look)));
    const double most = mostCandidates(entry, part);
    if (wanted > part.count.lines)
      part.count += lines_.drawUniform(part.index, look, wanted - part.count.lines, most, vectors_);
    if (part.count.open == part.count.lines)
      part.guess = static_cast<float>(lines_.guessVisibility(part.index, look, vectors_));
    if (look > 0) continue;
    const double each = part.exchange / double(part.count.lines);
    entry.first_facing += each * double(part.count.facing), entry.first_open += each * double(part.count.open);
    entry.first_variance += each * part.exchange * (part.count.open < part.count.lines);
  }
}

// Sets interval, value and standard error after a look.    Out: whether the interval is as narrow as the guarantee
// needs it
bool LineGuarantee::settle(Entry& entry, uint32_t look) const {
  const double blockable = entry.blockable(), rounding = kRoundingError * entry.exchange;
  double facing = 0, open = 0, guess = 0, lines = 0;
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    const Part& part = parts_[entry.first_part + k];
    facing += part.exchange * double(part.count.facing) / double(part.count.lines);
    const double open_here = part.exchange * double(part.count.open) / double(part.count.lines);
    open += open_here, guess += open_here * part.guess;
    lines += double(part.count.lines);
  }
  Interval seen{0, blockable};
  const bool is_proved = options_.delta == 0 || entry.isBounded();
  if (!is_proved) {
    // The variables are what each line adds, over the largest of them.
    const double most = weightAt(entry, look) * lines;
    const MeanBounds mean = chernoffBounds(facing / most, (facing + open) / most, lines, log_entry_);
    seen = {std::min(blockable, most * mean.lower), std::min(blockable, most * mean.upper)};
  }
  entry.interval = {std::max(0.0, entry.clear + seen.lower - rounding), entry.clear + seen.upper + rounding};
  entry.value = std::clamp(entry.clear + facing + guess, entry.interval.lower, entry.interval.upper);
  // Half a line of either kind is added, as in eq. (46).
  const double share = blockable > 0 ? (facing + guess) / blockable : 0, likely = (lines * share + 0.5) / (lines + 1);
  entry.standard_error =
      entry.part_count ? blockable * std::sqrt(likely * (1 - likely) / (lines + 1) + 0.25 / ((lines + 1) * (lines + 1)))
                       : 0;
  entry.standard_error += 1e-6 * entry.value;
  const double off = std::max(entry.interval.upper - entry.value, entry.value - entry.interval.lower);
  return is_proved || off <= options_.epsilon * ids_.smallerArea(entry.i, entry.j);
}

void LineGuarantee::step() {
  std::vector<char> is_done(open_.size(), false);
  forEach(open_.size(), [&](size_t k) {
    Entry& entry = entries_[open_[k]];
    draw(entry, look_);
    is_done[k] = settle(entry, look_);
    if (is_done[k] || look_ + 1 < entry.looks) return;
    throw Error(
        ErrorCode::limit,
        fmt::format("rounding leaves the form factor of {} and {} open, so that it cannot be guaranteed; ask for "
                    "a larger --epsilon, or an estimate by --tolerance",
                    ids_.names[entry.i], nameOf(entry.j)));
  });
  std::vector<uint32_t> still_open;
  for (size_t k = 0; k < open_.size(); ++k)
    if (!is_done[k]) still_open.push_back(open_[k]);
  open_ = std::move(still_open);
  if (++look_ == 1 && options_.rows) requireRows();
}

std::vector<LineGuarantee::Row> LineGuarantee::sumRows() const {
  std::vector<Row> rows(ids_.count());
  const auto addTo = [&](uint32_t id, const Entry& entry) {
    Row& row = rows[id];
    row.lower += entry.interval.lower, row.upper += entry.interval.upper;
    row.first += entry.clear + entry.first_facing, row.open += entry.first_open, row.squares += entry.first_variance;
    row.rounding += kRoundingError * entry.exchange;
  };
  for (const Entry& entry : entries_) {
    addTo(entry.i, entry);
    if (entry.j < kEnvironment && entry.j != entry.i) addTo(entry.j, entry);
  }
  return rows;
}

// Refuses rows of which too much is left open after the first look, as their bound can no longer be kept.
void LineGuarantee::requireRows() const {
  const std::vector<Row> rows = sumRows();
  for (uint32_t id = 0; id < ids_.count(); ++id) {
    if (!ids_.isRequested(id) || !ids_.counts_environment) continue;
    const double off =
        (std::sqrt(log_row_ * rows[id].squares / 2) + rows[id].rounding + rows[id].open) / ids_.areas[id];
    if (off > options_.epsilon)
      throw Error(
          ErrorCode::limit,
          fmt::format("the row of {} sees slivers beside it in so many pairs that its environment is bounded to "
                      "{:.2e} only; ask for a larger --epsilon, or leave out --rows",
                      ids_.names[id], off));
  }
}

// Adds what each row's first lines say together, and what the row's other entries leave.
std::vector<Interval> LineGuarantee::findIntervals(const FormFactors& form_factors) const {
  const std::vector<Row> rows = sumRows();
  const auto leftBy = [&](uint32_t id) {
    const Row& row = rows[id];
    const double area = ids_.areas[id];
    Interval left{std::max(0.0, area - row.upper), std::max(0.0, area - row.lower)};
    if (options_.delta == 0) return left;
    const double bound = std::sqrt(log_row_ * row.squares / 2) + row.rounding;
    left.lower = std::max(left.lower, std::min(left.upper, area - row.first - row.open - bound));
    left.upper = std::max(left.lower, std::min(left.upper, area - row.first + bound));
    return left;
  };
  std::vector<Interval> intervals;
  auto at = entries_.begin();
  for (const FormFactors::Entry& wanted : form_factors.entries()) {
    if (wanted.j == kEnvironment) {
      intervals.push_back(leftBy(wanted.i));
      continue;
    }
    while (at != entries_.end() && keyOf(*at) < keyOf(wanted)) ++at;
    if (at == entries_.end() || keyOf(*at) != keyOf(wanted)) {  // leak that only common directions have counted
      intervals.push_back({0, leftBy(wanted.i).upper});
      continue;
    }
    Interval interval = at->interval;
    if (ids_.counts_environment)
      for (const uint32_t id : {at->i, at->j})
        if (id < kEnvironment && ids_.isRequested(id))
          interval.upper =
              std::min(interval.upper, std::max(interval.lower, ids_.areas[id] - rows[id].lower + interval.lower));
    intervals.push_back(interval);
  }
  return intervals;
}

// Adds the environment of rows that look as if they saw none: their intervals say how much it may be.
FormFactors LineGuarantee::withEveryEnvironment(FormFactors all) const {
  std::vector<char> has_environment(ids_.count(), false);
  bool is_open = false;
  for (const FormFactors::Entry& entry : all.entries())
    if (entry.j == kEnvironment) has_environment[entry.i] = is_open = true;
  if (!is_open) return all;
  std::vector<Measured> row_sums = all.rowSums();
  const Ids ids = all.ids();
  std::vector<FormFactors::Entry> entries = std::move(all).entries();
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (has_environment[id] || !ids.isRequested(id)) continue;
    const double left = std::max(0.0, 1 - row_sums[id].value) * ids.areas[id];
    entries.push_back({id, kEnvironment, {left, row_sums[id].standard_error * ids.areas[id]}});
    row_sums[id].value = std::max(row_sums[id].value, 1.0);
  }
  std::ranges::sort(entries, {}, keyOf<FormFactors::Entry>);
  return {ids, std::move(entries), std::move(row_sums)};
}

Estimate LineGuarantee::estimate(const RunSums& sums, double relative_floor) const {
  std::vector<FormFactors::Entry> entries;
  Estimate estimate{FormFactors({}, {}, {}), FormFactors({}, {}, {})};
  // Without lines all is certain, intervals of the environment too.
  const bool needs_lines = figures_.drawn || (ids_.counts_environment && !parts_.empty());
  Guarantee guarantee{options_.epsilon, needs_lines ? options_.delta : 0, 0, GuaranteedBy::chernoff};
  for (const Entry& entry : entries_) {
    entries.push_back({entry.i, entry.j, {entry.value, entry.standard_error}});
    estimate.line_pairs += entry.part_count > 0;
    for (uint32_t k = 0; k < entry.part_count; ++k) estimate.lines += parts_[entry.first_part + k].count.lines;
    if (entry.j == kLeak) continue;
    const double off = std::max(entry.interval.upper - entry.value, entry.value - entry.interval.lower);
    guarantee.bound = std::max(guarantee.bound, off / ids_.smallerArea(entry.i, entry.j));
  }
  const bool by_polygon = options_.by == By::polygon;
  const ReplicateSums& counted = by_polygon ? sums.by_id : sums.by_surface;
  FormFactors all = lineFormFactors(entries, {}, By::polygon, counted, sums.measure_area, sums.countArea());
  estimate.between_surfaces = by_polygon ? lineFormFactors(std::move(entries), face_ids_.surface, By::surface,
                                                           sums.by_surface, sums.measure_area, sums.countArea())
                                         : all;
  estimate.between_surfaces = keepSeen(std::move(estimate.between_surfaces));
  estimate.replicates = look_;
  estimate.directions = sums.directions;
  estimate.largest_standard_error = largestStandardError(all);
  estimate.largest_relative_error = largestRelativeError(all, relative_floor);
  estimate.interrupted = !isDone();
  if (!isDone()) {
    estimate.form_factors = keepSeen(std::move(all));
    return estimate;
  }
  all = withEveryEnvironment(std::move(all));
  std::vector<Interval> intervals = findIntervals(all);
  std::vector<Measured> row_sums = all.rowSums();
  const Ids ids = all.ids();
  std::vector<FormFactors::Entry> found = std::move(all).entries();
  // The environment's value is what values leave, and its interval follows from other sums.
  for (size_t k = 0; k < found.size(); ++k) {
    double& value = found[k].exchange_area.value;
    value = std::clamp(value, intervals[k].lower, intervals[k].upper);
    if (found[k].j != kEnvironment) continue;
    const double off = std::max(intervals[k].upper - value, value - intervals[k].lower) / ids.areas[found[k].i];
    guarantee.row_bound = std::max(guarantee.row_bound, off);
  }
  estimate.form_factors = FormFactors(ids, std::move(found), std::move(row_sums), std::move(intervals));
  estimate.guarantee = guarantee;
  return estimate;
}

}  // namespace viewpeel
