#include "estimator/line_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <viewpeel/error.h>
#include "memory.h"
#include "sums/add_pairs.h"
#include "sums/line_form_factors.h"

namespace viewpeel {
namespace {

// Returns how many standard errors an entry in this column must keep below the goal.
double errorsInGoal(uint32_t column) { return column < kEnvironment ? kErrorsInGoal : kErrorsInRowGoal; }

// Returns the error that a goal allows for an exchange area, input units squared.
double allowedBy(const EstimateOptions& options, double exchange, double smaller_area) {
  double allowed = options.tolerance ? *options.tolerance * smaller_area : INFINITY;
  // No visibility is known before the run, so a relative error refers to half of the unoccluded form factor.
  if (options.relative && exchange >= options.relative_floor * smaller_area)
    allowed = std::min(allowed, *options.relative * exchange / 2);
  return allowed;
}

using Key = std::pair<uint32_t, uint32_t>;

constexpr double kSpare = 1.2;       // lines drawn, over the lines that an error asks for
constexpr double kMostGrowth = 16;   // of a pair's lines, by one replicate
constexpr int kMostPlans = 8;        // plans of lines for one goal: the goal, and coarser ones until the lines fit
constexpr double kSlack = 2;         // lines of a coarser goal may exceed their limit by this factor
constexpr double kMostTimes = 1000;  // most multiples of planned lines, so that LineCount's units suffice
// If common directions count pairs, a run ends short of its goal after this multiple of its planned replicates.
constexpr uint64_t kMostMixtureGrowth = 8;

RunSums sumsToBeginWith(const Scene& scene, const Ids& face_ids, std::vector<LinePair> pairs, double least_form_factor,
                        const EstimateOptions& options) {
  RunSums sums = makeRunSums(scene, face_ids);
  if (!options.resumed) {
    sums.lines.emplace(face_ids, options.by, std::move(pairs), least_form_factor);
    return sums;
  }
  const LineSums& resumed = *options.resumed->lines;
  sums.lines.emplace(face_ids, options.by, resumed.pairs(), resumed.leastFormFactor());
  return sums;
}

// Leaves out counts of pairs that have lines, or of all pairs where each has.
void leaveOutPairsWithLines(PairCounts& counts, const LineSums& lines) {
  if (lines.leastFormFactor() == 0) {
    std::erase_if(counts, [](const PairCount& count) { return count.j < kEnvironment; });
    return;
  }
  auto at = lines.pairs().begin();
  const auto end = lines.pairs().end();
  std::erase_if(counts, [&](const PairCount& count) {
    while (at != end && keyOf(*at) < keyOf(count)) ++at;
    return at != end && keyOf(*at) == keyOf(count);
  });
}

}  // namespace

std::vector<LinePair> planLines(PairLines& lines, std::vector<LinePair> pairs, const Ids& face_ids, const Ids& ids,
                                const EstimateOptions& options, double most_lines) {
  // A Sum is an entry between surfaces, or a row's leak: a sum over many pairs with independent errors. Parts of the
  // variance as in eq. (48) of docs/method.md need the fewest lines.
  struct Sum {
    double exchange = 0, parts = 0;
  };
  std::map<Key, Sum> of_entries;
  const auto partOf = [](const LinePair& pair) { return std::pow(pair.exchange - pair.clear, 8.0 / 9); };
  for (const LinePair& pair : pairs) {
    const Key key = entryOf(pair, face_ids, options.by);
    if (key == keyOf(pair)) continue;
    Sum& sum = of_entries[key];
    sum.exchange += pair.exchange;
    sum.parts += partOf(pair);
  }
  const auto allowedTo = [&](const LinePair& pair) {
    const Key key = entryOf(pair, face_ids, options.by);
    const double area = ids.smallerArea(key.first, key.second), errors = errorsInGoal(key.second);
    const auto sum = of_entries.find(key);
    if (sum == of_entries.end()) return allowedBy(options, pair.exchange, area) / errors;
    return allowedBy(options, sum->second.exchange, area) / errors * std::sqrt(partOf(pair) / sum->second.parts);
  };
  // If the plan has too many lines, all allowed errors are multiplied by `relief`. The number of lines goes as the
  // error to the power of -8/5, or of -1 for pairs whose lines all agree (kAgreeingLines). No pair gets more than
  // kMostLineBlocks, so the first sum of lines may be too small, and a second relief may be needed.
  double relief = 1, power = 5.0 / 8;
  for (int plans = 0; plans < kMostPlans; ++plans, power = 1) {
    lines.plan(
        pairs, [&](const LinePair& pair) { return relief * allowedTo(pair); }, options.replicates);
    double all = 0;
    for (const LinePair& pair : pairs) all += pair.linesIn(options.replicates);
    if (!(all > (plans ? kSlack : 1) * most_lines)) break;
    relief *= std::pow(all / most_lines, power);
  }
  lines.cutAndPlan(
      pairs, [&](const LinePair& pair) { return relief * allowedTo(pair); }, options.replicates);
  return pairs;
}

LineRun::LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
                 double least_form_factor, EstimateOptions options)
    : engine_(engine),
      lines_(lines),
      options_(std::move(options)),
      count_area_(options_.directions ? engine.unitArea() * scene.scale * scene.scale / options_.directions : 0),
      sums_(sumsToBeginWith(scene, face_ids, std::move(pairs), least_form_factor, options_)) {
  if (options_.replicates < 2) throw Error(ErrorCode::bad_usage, "a standard error needs at least 2 replicates");
  if (options_.resumed) {
    sums_.add(*options_.resumed);
    resumed_count_ = sums_.replicateCount();
    measureErrors();
  }
}

// Returns the variance that each entry of a row may have for the row's environment to reach its goal; infinite where it
// has reached it. A row's environment is 1 less its pairs, so their variances add up. The fewest lines are needed where
// the largest variances are all reduced to the same size.
std::vector<double> LineRun::findRowVariances(const FormFactors& all) const {
  const Ids& ids = all.ids();
  std::vector<double> sums(ids.count()), most(ids.count(), INFINITY);
  // If common directions count the leak, lines of pairs cannot improve it.
  const bool has_leak = sums_.lines->hasBacks();
  const auto forEachPart = [&](const auto& add) {
    for (const FormFactors::Entry& entry : all.entries())
      for (const uint32_t id : {entry.i, entry.j})
        if (id < kEnvironment && (entry.j < kEnvironment || (has_leak && entry.j == kLeak)))
          add(id, std::pow(entry.exchange_area.standard_error, 2));
  };
  forEachPart([&](uint32_t id, double variance) { sums[id] += variance; });
  std::map<uint32_t, std::vector<double>> parts;
  const auto wantRow = [&](uint32_t id, double excess) {
    if (!(excess > 1)) return;
    parts[id];
    sums[id] /= excess * excess;  // variance that the row may have
  };
  std::vector<bool> has_environment(ids.count());
  bool is_open = false;
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j != kEnvironment) continue;
    is_open = has_environment[entry.i] = true;
    wantRow(entry.i, excessOf({entry.i, kEnvironment, {entry.exchange_area.value, std::sqrt(sums[entry.i])}}, ids));
  }
  // In an open scene another row may see the environment, too, where its pairs leave something of it. It gets an
  // environment if that is more than kBeyondDoubt standard errors, which therefore must be within the tolerance.
  for (uint32_t id = 0; is_open && options_.tolerance && id < ids.count(); ++id)
    if (ids.isRequested(id) && !has_environment[id] && all.rowSums()[id].value < 1)
      wantRow(id, kBeyondDoubt * std::sqrt(sums[id]) / (*options_.tolerance * ids.areas[id]));
  if (parts.empty()) return most;
  forEachPart([&](uint32_t id, double variance) {
    if (const auto row = parts.find(id); row != parts.end()) row->second.push_back(variance);
  });
  for (auto& [id, variances] : parts) {
    std::ranges::sort(variances);
    double left = sums[id];
    for (size_t k = 0; k < variances.size(); ++k) {
      most[id] = left / double(variances.size() - k);
      if (variances[k] >= most[id]) break;
      left -= variances[k];
    }
  }
  return most;
}

void LineRun::measureErrors() {
  if (sums_.replicateCount() < options_.replicates) return;
  std::optional<FormFactors> all = sums_.formFactors();
  largest_error_ = viewpeel::largestStandardError(*all);
  planFurther(hasCountedPairs() ? findWantingOfMixture(*all) : findWanting(*all));
  const bool is_large = all->entries().size() > kLargeList;
  all.reset();
  if (is_large) returnFreedMemory();
}

// Returns the entries whose lines are too few for the goals, sorted, and their errors over the errors allowed.
LineRun::Wanting LineRun::findWanting(const FormFactors& all) const {
  const Ids& ids = all.ids();
  const std::vector<double> row_variances = findRowVariances(all);
  Wanting wanting;
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j == kEnvironment) continue;
    const double error = entry.exchange_area.standard_error;
    double excess = excessOf(entry, ids);
    for (const uint32_t id : {entry.i, entry.j})
      if (id < kEnvironment) excess = std::max(excess, error / std::sqrt(row_variances[id]));
    if (excess > 1) wanting.emplace_back(keyOf(entry), excess);
  }
  return wanting;
}

// Returns the entries whose lines are too few, as findWanting(), where common directions have counted some pairs.
// Further lines reduce only the part of an entry's error that is due to lines.
//   Out: needs_directions_: whether the part due to common directions is too large for an entry
LineRun::Wanting LineRun::findWantingOfMixture(const FormFactors& all) {
  const Ids& ids = all.ids();
  // Between faces, lines have an entry for each pair in order, for common directions count the leak. Large scenes have
  // no memory for a second list of them.
  const LineSums& of_pairs = *sums_.lines;
  const bool by_polygon = options_.by == By::polygon && !of_pairs.hasBacks();
  const std::vector<FormFactors::Entry> merged =
      by_polygon ? std::vector<FormFactors::Entry>{} : of_pairs.entriesOfResult();
  const size_t count = by_polygon ? of_pairs.pairs().size() : merged.size();
  const auto keyAt = [&](size_t k) { return by_polygon ? keyOf(of_pairs.pairs()[k]) : keyOf(merged[k]); };
  const auto errorAt = [&](size_t k) {
    return (by_polygon ? of_pairs.exchangeArea(k) : merged[k].exchange_area).standard_error;
  };
  Wanting wanting;
  needs_directions_ = false;
  size_t line = 0;
  for (const FormFactors::Entry& entry : all.entries()) {
    const double excess = excessOf(entry, ids);
    if (!(excess > 1)) continue;
    while (line < count && keyAt(line) < keyOf(entry)) ++line;
    const bool has_lines = line < count && keyAt(line) == keyOf(entry);
    const double of_lines = has_lines ? errorAt(line) : 0, whole = entry.exchange_area.standard_error,
                 allowed = whole / excess, of_counts = std::sqrt(std::max(0.0, whole * whole - of_lines * of_lines));
    if (has_lines && of_counts < allowed)
      wanting.emplace_back(keyOf(entry), of_lines / std::sqrt(allowed * allowed - of_counts * of_counts));
    // Pairs of polygons that were counted are within the goal whatever their counts (kMostOfCounted).
    else if (options_.by == By::surface || entry.j >= kEnvironment) needs_directions_ = true;
  }
  return wanting;
}

// Plans the next replicate: lines that bring the wanting entries to the goal, and common directions if an entry needs
// them.
void LineRun::planFurther(const Wanting& wanting) {
  const std::vector<LinePair>& pairs = sums_.lines->pairs();
  further_.assign(wanting.empty() ? 0 : pairs.size(), 0);
  is_reached_ = true;
  for (size_t k = 0; k < further_.size(); ++k) {
    if (pairs[k].blocks == 0) continue;
    const Key key = entryOf(pairs[k], sums_.lines->ids(), options_.by);
    const auto at = std::ranges::lower_bound(wanting, key, {}, &std::pair<Key, double>::first);
    if (at == wanting.end() || at->first != key) continue;
    // The number of lines is proportional to the error to the power of -8/5. kMostGrowth limits it, because an error
    // from few lines is rough.
    const double lines = std::min(kSpare * std::pow(at->second, 8.0 / 5), kMostGrowth) - 1,
                 times = lines * double(sums_.lines->sumOf(k).blocks) / pairs[k].blocks;
    further_[k] = static_cast<uint32_t>(std::clamp(std::ceil(times), 1.0, kMostTimes));
    is_reached_ = false;
  }
  if (is_reached_) further_.clear();
  if (!hasCountedPairs() || !needs_directions_) return;
  is_reached_ = false;
  if (sums_.replicateCount() < kMostMixtureGrowth * options_.replicates &&
      double(sums_.by_id.pairs().size()) < kMostCountedPairs)
    further_.resize(pairs.size(), 0);
}

// Returns an entry's error over the error that the goals allow.
double LineRun::excessOf(const FormFactors::Entry& entry, const Ids& ids) const {
  const double area = ids.smallerArea(entry.i, entry.j),
               error = errorsInGoal(entry.j) * entry.exchange_area.standard_error;
  double excess = options_.tolerance ? error / (*options_.tolerance * area) : 0;
  if (options_.relative && entry.exchange_area.value >= options_.relative_floor * area)
    excess = std::max(excess, error / (*options_.relative * entry.exchange_area.value));
  return excess;
}

bool LineRun::isDone() const {
  const uint64_t done = sums_.replicateCount();
  const auto done_here = double(done - resumed_count_);
  double next = secondsSince(start_) / std::max(done_here, 1.0);
  if (!further_.empty() && !needs_directions_)
    next *= furtherLines() / (double(sums_.lines->lineCount()) / double(done));
  if (options_.seconds && done >= 2 && done_here > 0 && secondsSince(start_) + next > *options_.seconds) return true;
  return done >= options_.replicates && (options_.is_exact || further_.empty());
}

// Returns the number of further lines in the next replicate.
double LineRun::furtherLines() const {
  double lines = 0;
  for (size_t k = 0; k < further_.size(); ++k)
    lines += further_[k] * sums_.lines->pairs()[k].linesIn(1) * sums_.lines->pairs()[k].period;
  return lines;
}

void LineRun::step() {
  const uint64_t replicate = options_.first_replicate + sums_.replicateCount();
  const LineCounts counts = lines_.count(sums_.lines->pairs(), replicate, further_);
  PairCounts common;
  if (options_.directions)
    common = engine_.count(sampleDirections(options_.sampler, options_.directions, options_.seed, replicate));
  leaveOutPairsWithLines(common, *sums_.lines);
  if (sums_.replicateCount() == 0) sums_.measure_area = count_area_;
  sums_.addLines(replicate, common, options_.directions, counts);
  common = {};  // measuring takes as much memory
  measureErrors();
}

Estimate LineRun::estimate() const { return makeEstimate(sums_, options_.relative_floor); }

}  // namespace viewpeel
