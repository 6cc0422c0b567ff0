// This file plans a guarantee by pair lines: which entries need lines, how many at most, and how many are expected.
#include "estimator/line_guarantee.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/promise_cost.h"
#include "stopwatch.h"
#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

constexpr uint32_t kMostEntryLooks = 5;  // at uniform lines; from the second on each has twice the lines of the last
// An entry has at most this number of bounds, each of which may fail. A look at uniform lines has two, one for each
// side. A look at strata has four, one more for the variance of each side. An entry has the most bounds with the first
// look, three looks at strata, and the last look. Five looks at uniform lines have ten.
constexpr double kMostBounds = 2 + 3 * 4 + 2;
constexpr double kShareByNeed = 0.5;         // part of delta shared by need of lines; the rest is shared evenly
constexpr double kFewestLines = 16;          // least lines of an entry
constexpr double kLeastRoundingShare = 0.5;  // least part of epsilon that rounding must leave
constexpr double kShareOfLines = 0.98;       // part of an entry's error; the rest is for open lines
constexpr double kShareOfRowLines = 0.9;     // part of a row's error; the rest is for open parts, too
constexpr double kFirstLook = 1.2;           // times the lines that end an entry where no line is facing
constexpr double kRowShare = 0.5;            // part of delta for rows, if rows have bounds
constexpr uint64_t kPilotSeries = 1000;      // series of pilots; looks have smaller numbers
constexpr size_t kMostPilots = 512;          // entries with a pilot
constexpr double kMostPilotLines = 256;      // of an entry

// Returns the largest weight c of a line for which Hoeffding's bound is at most `allowed`: docs/method.md, eq. (50). A
// part of exchange area G_k has ceil(G_k / c) lines, so all have at most blockable / c + parts. Hence c is the root of
// c^2 (blockable / c + parts) l / 2 = allowed^2.
//   In: blockable: the sum of G_k; parts: their number; l: ln(2 / p), where p is the chance that the bound fails
double hoeffdingWeight(double blockable, double parts, double allowed, double l) {
  return (std::sqrt(blockable * blockable + 8 * parts * allowed * allowed / l) - blockable) / (2 * parts);
}

}  // namespace

LineGuarantee::LineGuarantee(const Scene& scene, const Ids& face_ids, const Ids& ids, PairLines& lines,
                             const std::vector<LinePair>& pairs, const LineGuaranteeOptions& options)
    : scene_(scene), face_ids_(face_ids), ids_(ids), lines_(lines), options_(options) {
  const auto begun = Clock::now();
  options_.rows &= options_.delta > 0;  // with delta 0, lines prove nothing about a row's sum
  collectEntries(pairs);
  planLooks();
  if (options_.rows) planRows();
  predict();
  open_.resize(entries_.size());
  std::iota(open_.begin(), open_.end(), 0u);
  // Entries with most lines come first, so that no thread ends with one of these alone.
  std::vector<double> most;
  for (const Entry& entry : entries_) most.push_back(linesOf(entry, entry.looks - 1));
  std::ranges::stable_sort(open_, std::ranges::greater{}, [&](uint32_t k) { return most[k]; });
  const double e = options_.epsilon, d = options_.delta, bounds = double(std::max<size_t>(entries_.size(), 1));
  figures_.epsilon = e, figures_.delta = d, figures_.least_form_factor = options.least_form_factor;
  figures_.lemma_1 = 1 / (e * e * d), figures_.lemma_1_all = bounds / (e * e * d);
  figures_.median_directions = std::ceil(8 * std::log(bounds / d)) * 4 / (e * e);
  figures_.plan_seconds = secondsSince(begun);
}

void LineGuarantee::collectEntries(const std::vector<LinePair>& pairs) {
  pairs_ = pairs.size();
  std::vector<std::pair<std::pair<uint32_t, uint32_t>, uint32_t>> by_key;
  by_key.reserve(pairs.size());
  for (uint32_t k = 0; k < pairs.size(); ++k) by_key.push_back({entryOf(pairs[k], face_ids_, options_.by), k});
  std::ranges::sort(by_key);
  entries_.reserve(by_key.size());  // as many where each pair is an entry, and pages that are not used take no memory
  for (const auto& [key, k] : by_key) {
    if (entries_.empty() || keyOf(entries_.back()) != key) {
      entries_.push_back({key.first, key.second});
      entries_.back().first_part = static_cast<uint32_t>(parts_.size());
    }
    // Two faces of one surface exchange both ways within it.
    const double ways = key.first == key.second ? 2 : 1;
    Entry& entry = entries_.back();
    entry.clear += ways * pairs[k].exchange;  // the blockable parts are left out below
    entry.error += ways * pairs[k].error;
    for (const PairLines::Part& part : lines_.blockableParts(k))
      parts_.push_back({part.index, ways * part.exchange, part.blockers});
    entry.part_count = static_cast<uint32_t>(parts_.size()) - entry.first_part;
  }
  for (Entry& entry : entries_) {
    for (uint32_t k = 0; k < entry.part_count; ++k) entry.blockable += parts_[entry.first_part + k].exchange;
    entry.clear = std::max(0.0, entry.clear - entry.blockable);
    const double area = ids_.smallerArea(entry.i, entry.j);
    entry.allowed = options_.epsilon * area - entry.rounding();
    if (entry.allowed < kLeastRoundingShare * options_.epsilon * area)
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("--epsilon {} is too small for the rounding errors of a guarantee; ask for {:.0e} or more",
                      options_.epsilon, kRoundingError / (1 - kLeastRoundingShare)));
    if (isOutsideResult(entry) && !options_.rows) entry.allowed = INFINITY;  // no promise is made for leak alone
  }
}

void LineGuarantee::planLooks() {
  const auto isDrawn = [&](const Entry& entry) { return options_.delta > 0 && !entry.isBounded(); };
  const bool has_rows = ids_.counts_environment && options_.delta > 0;
  const double drawn = double(std::ranges::count_if(entries_, isDrawn)),
               delta = options_.delta * (has_rows ? 1 - kRowShare : 1);
  double all_needs = 0;
  for (const Entry& entry : entries_)
    if (isDrawn(entry)) all_needs += entry.blockable / entry.allowed;
  log_row_ = std::log(2 * double(ids_.count()) / (kRowShare * options_.delta));
  for (Entry& entry : entries_) {
    const double blockable = entry.blockable;
    ++(entry.part_count == 0 ? figures_.exact : isDrawn(entry) ? figures_.drawn : figures_.bounded);
    if (entry.part_count == 0) continue;
    entry.weight = entry.first_weight = blockable / kFewestLines;
    if (isOutsideResult(entry) && !options_.rows) {
      // It gets enough lines for a standard error of at most epsilon.
      const double allowed = options_.epsilon * ids_.smallerArea(entry.i, entry.j);
      entry.weight = entry.first_weight = std::min(entry.weight, 4 * allowed * allowed / blockable);
    }
    if (!isDrawn(entry)) {
      entry.most_candidates = isOutsideResult(entry) ? kMostCandidatesOfSums : kMostCandidates;
      continue;
    }
    planEntryLooks(entry,
                   delta * (kShareByNeed * entry.blockable / entry.allowed / all_needs + (1 - kShareByNeed) / drawn));
  }
}

// Plans the looks at an entry.    In: chance: p_k of section 14, with which any of its bounds may fail
void LineGuarantee::planEntryLooks(Entry& entry, double chance) {
  const double blockable = entry.blockable, allowed = kShareOfLines * entry.allowed, fewest = entry.weight;
  double first = 0;
  for (const double bounds : {2.0, kMostBounds}) {
    const double l = std::log(bounds / chance);
    entry.log_chance = l;
    entry.weight = std::min(fewest, hoeffdingWeight(blockable, entry.part_count, allowed, l));
    first = entry.first_weight = std::max(entry.weight, std::min(fewest, allowed / (kFirstLook * l)));
    if (first < 2 * entry.weight) break;  // one look, and a bound on either side
  }
  entry.looks = std::min(kMostEntryLooks, 1 + static_cast<uint32_t>(std::log2(first / entry.weight)));
  if (entry.looks == 1) entry.first_weight = entry.weight;
}

// Gives first looks so many lines that the bound (55) on each row's sum is epsilon.
void LineGuarantee::planRows() {
  std::vector<double> blockable(ids_.count(), 0), parts(ids_.count(), 0), rounding(ids_.count(), 0),
      entry_counts(ids_.count(), 0);
  const auto addTo = [&](uint32_t row, const Entry& entry) {
    blockable[row] += entry.blockable, parts[row] += entry.part_count;
    rounding[row] += entry.rounding();
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
      if (entry.blockable * entry_counts[row] > kShareOfOpen * options_.epsilon * ids_.areas[row])
        entry.most_candidates = std::max(entry.most_candidates, kMostCandidatesOfSums);
    });
    entry.weight = std::min(entry.weight, most), entry.first_weight = std::min(entry.first_weight, most);
    while (entry.looks > 1 && weightAt(entry, 1) >= entry.first_weight) --entry.looks;
    if (entry.looks == 1) entry.weight = entry.first_weight;
  }
}

// Returns the number of uniform lines that an entry is expected to need, up to the first look at which Bernstein's
// bound is no more than the entry may err.    In: share: of its lines that nothing blocks
double LineGuarantee::expectedLines(const Entry& entry, double share) const {
  const double variance = share * (1 - share);
  for (uint32_t look = 0; look + 1 < entry.looks; ++look) {
    const double n = linesOf(entry, look), bound = entry.blockable * (std::sqrt(2 * variance * entry.log_chance / n) +
                                                                      entry.log_chance / (3 * n));
    if (bound <= entry.allowed) return n;
  }
  return linesOf(entry, entry.looks - 1);
}

// Draws a few lines of an entry: an eighth of its first look, within limits.
UniformLineCount LineGuarantee::drawPilot(const Entry& entry) const {
  UniformLineCount sum;
  const auto lines = static_cast<uint64_t>(std::clamp(linesOf(entry, 0) / 8, kFewestLines, kMostPilotLines));
  for (uint32_t k = 0; k < entry.part_count && k < kFewestLines; ++k) {
    const Part& part = parts_[entry.first_part + k];
    sum += lines_.drawUniform(part.index, kPilotSeries, lines / entry.part_count + 1, mostCandidates(entry, part),
                              vectors_);
  }
  return sum;
}

// Predicts the lines and the cost of all entries from pilots of some entries. The probability that an entry gets a
// pilot is proportional to the most lines that it may need. A pilot counts as one over this probability, so that sums
// have no bias.
void LineGuarantee::predict() {
  std::vector<uint32_t> uncertain;
  double most_uncertain = 0;
  PromiseCost cost(options_.epsilon, {scene_.faces.size(), options_.directions, pairs_, lines_.findingWork()});
  const auto add = [&](const Entry& entry, double lines, double candidates, double strata, double share,
                       double weight) {
    const std::span<const Part> parts(parts_.data() + entry.first_part, entry.part_count);
    std::vector<double> exchanges;
    double blockers = 0;
    for (const Part& part : parts) exchanges.push_back(part.exchange), blockers += double(part.blockers);
    cost.add({exchanges, ids_.smallerArea(entry.i, entry.j), entry.j < kEnvironment, share, lines, candidates, strata,
              blockers},
             weight);
    figures_.expected_lines += weight * (lines + strata);
  };
  for (uint32_t k = 0; k < entries_.size(); ++k) {
    const Entry& entry = entries_[k];
    if (entry.part_count == 0) continue;
    const double most = linesOf(entry, entry.looks - 1);
    figures_.most_lines += most + mostStrata(entry);
    most_looks_ = std::max(most_looks_, entry.looks == 1 ? 1 : std::max(entry.looks, 2 + kStrataLooks));
    if (most > figures_.most_for_one)
      figures_.most_for_one = most, figures_.neediest = {ids_.names[entry.i], nameOf(entry.j)};
    // An estimate would draw this least number of lines, too.
    if (most <= kFewestLines + entry.part_count) add(entry, most, most, 0, 0.5, 1);
    else uncertain.push_back(k), most_uncertain += most;
  }
  // The entries are laid end to end, each as long as the most lines that it may need. Entries at equal distances along
  // this row get a pilot (systematic sampling).
  std::vector<std::pair<uint32_t, double>> pilots;  // entry and weight
  const double step = most_uncertain / double(kMostPilots);
  double sum = 0;
  for (const uint32_t k : uncertain) {
    const double most = linesOf(entries_[k], entries_[k].looks - 1), before = std::floor(sum / step + 0.5),
                 turns = std::floor((sum += most) / step + 0.5) - before;
    if (uncertain.size() <= kMostPilots) pilots.emplace_back(k, 1);
    else if (turns > 0) pilots.emplace_back(k, turns * step / most);
  }
  std::vector<UniformLineCount> counts(pilots.size());
  forEach(pilots.size(), [&](size_t k) { counts[k] = drawPilot(entries_[pilots[k].first]); });
  for (size_t k = 0; k < pilots.size(); ++k) {
    const Entry& entry = entries_[pilots[k].first];
    const UniformLineCount& count = counts[k];
    const double share = (double(count.facing) + 1) / (double(count.lines) + 2), all = expectedLines(entry, share),
                 candidates = double(count.candidates) / double(count.lines), first = linesOf(entry, 0),
                 strata = all > first ? worthStrata(entry, share, all, candidates) : 0,
                 lines = strata > 0 ? first : all;
    add(entry, lines, lines * candidates, strata, share, pilots[k].second);
  }
  figures_.cost = cost.ofPromise(), figures_.estimate_cost = cost.ofEstimate();
  lines_cost_ = cost.ofLines();
}

// Predicts the run's times. Finding the pairs has been timed; its seconds over its predicted cost say how fast the
// machine is.
void LineGuarantee::predictSeconds(double finding_seconds) {
  const double finding = PromiseCost::ofFinding({.pairs = pairs_, .finding = lines_.findingWork()});
  if (!(finding > 0) || !(figures_.expected_lines > 0)) return;
  const double seconds = lines_cost_ * finding_seconds / finding;
  figures_.expected_seconds = seconds;
  figures_.most_seconds = seconds * std::max(1.0, figures_.most_lines / figures_.expected_lines);
}

}  // namespace viewpeel
