#include "estimator/line_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <viewpeel/error.h>
#include "sums/add_pairs.h"

namespace viewpeel {
namespace {

// Standard errors that make up a goal, of an entry in this column.
double errorsInGoal(uint32_t column) { return column < kEnvironment ? kErrorsInGoal : kErrorsInRowGoal; }

// What a goal allows an exchange area, input units squared.
double allowedBy(const EstimateOptions& options, double exchange, double smaller_area) {
  double allowed = options.tolerance ? *options.tolerance * smaller_area : INFINITY;
  // The least visibility is not known before the run: an error relative to what is seen is one of half of it.
  if (options.relative && exchange >= options.relative_floor * smaller_area)
    allowed = std::min(allowed, *options.relative * exchange / 2);
  return allowed;
}

using Key = std::pair<uint32_t, uint32_t>;

RunSums sumsToBeginWith(const Scene& scene, const Ids& face_ids, std::vector<LinePair> pairs,
                        const EstimateOptions& options) {
  RunSums sums = makeRunSums(scene, face_ids);
  sums.lines.emplace(face_ids, options.by, options.resumed ? options.resumed->lines->pairs() : std::move(pairs));
  return sums;
}

}  // namespace

std::vector<LinePair> planLines(PairLines& lines, const Ids& face_ids, const Ids& ids, const EstimateOptions& options,
                                double most_lines) {
  std::vector<LinePair> pairs = lines.find();
  // An entry between surfaces, and a row's leak, is a sum over many pairs with independent errors. Parts of the
  // variance as in eq. (48) of docs/method.md take the fewest lines.
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
  lines.plan(pairs, allowedTo, options.replicates);
  double all = 0;
  for (const LinePair& pair : pairs) all += pair.linesIn(options.replicates);
  if (!(all > most_lines)) return pairs;
  // The number of lines falls as the error to the power of -8/5.
  const double relief = std::pow(all / most_lines, 5.0 / 8);
  lines.plan(
      pairs, [&](const LinePair& pair) { return relief * allowedTo(pair); }, options.replicates);
  return pairs;
}

LineRun::LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
                 EstimateOptions options)
    : engine_(engine),
      lines_(lines),
      options_(std::move(options)),
      count_area_(options_.directions ? engine.unitArea() * scene.scale * scene.scale / options_.directions : 0),
      sums_(sumsToBeginWith(scene, face_ids, std::move(pairs), options_)) {
  if (options_.replicates < 2) throw Error(ErrorCode::bad_usage, "a standard error needs at least 2 replicates");
  if (options_.resumed) {
    sums_.add(*options_.resumed);
    resumed_count_ = sums_.replicateCount();
    measureErrors();
  }
}

void LineRun::measureErrors() {
  if (sums_.replicateCount() < options_.replicates) return;
  const FormFactors all = sums_.formFactors();
  largest_error_ = viewpeel::largestStandardError(all);
  const Ids& ids = all.ids();
  // The environment of a row is what its pairs leave: all of them have a part in its error.
  struct Row {
    double variance = 0, count = 0;
    bool is_wanting = false;
  };
  std::vector<Row> rows(ids.count());
  for (const FormFactors::Entry& entry : all.entries())
    for (const uint32_t id : {entry.i, entry.j}) {
      if (id >= kEnvironment || entry.j == kEnvironment) continue;
      rows[id].variance += std::pow(entry.exchange_area.standard_error, 2);
      rows[id].count += 1;
    }
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j != kEnvironment) continue;
    Row& row = rows[entry.i];
    row.is_wanting = isWanting({entry.i, kEnvironment, {entry.exchange_area.value, std::sqrt(row.variance)}}, ids);
  }
  std::set<Key> keys;
  for (const FormFactors::Entry& entry : all.entries()) {
    if (entry.j == kEnvironment) continue;
    const double variance = std::pow(entry.exchange_area.standard_error, 2);
    const auto isWantedBy = [&](const Row& row) { return row.is_wanting && variance * row.count > row.variance; };
    if (isWanting(entry, ids) || isWantedBy(rows[entry.i]) || (entry.j < kEnvironment && isWantedBy(rows[entry.j])))
      keys.insert(keyOf(entry));
  }
  const std::vector<LinePair>& pairs = sums_.lines->pairs();
  wanting_.assign(pairs.size(), false);
  is_any_wanting_ = false;
  for (size_t k = 0; k < pairs.size() && !keys.empty(); ++k) {
    wanting_[k] = pairs[k].blocks && keys.contains(entryOf(pairs[k], sums_.lines->ids(), options_.by));
    is_any_wanting_ = is_any_wanting_ || wanting_[k];
  }
}

bool LineRun::isWanting(const FormFactors::Entry& entry, const Ids& ids) const {
  const double area = ids.smallerArea(entry.i, entry.j),
               error = errorsInGoal(entry.j) * entry.exchange_area.standard_error;
  if (options_.tolerance && error > *options_.tolerance * area) return true;
  return options_.relative && entry.exchange_area.value >= options_.relative_floor * area &&
         error > *options_.relative * entry.exchange_area.value;
}

bool LineRun::isDone() const {
  const uint64_t done = sums_.replicateCount();
  const auto done_here = double(done - resumed_count_);
  // Further replicates have twice the lines of the one before.
  const double next = done >= options_.replicates ? 2 * last_seconds_ : secondsSince(start_) / std::max(done_here, 1.0);
  if (options_.seconds && done >= 2 && done_here > 0 && secondsSince(start_) + next > *options_.seconds) return true;
  return done >= options_.replicates && !is_any_wanting_;
}

void LineRun::step() {
  const auto begun = Clock::now();
  const uint64_t replicate = options_.first_replicate + sums_.replicateCount();
  // Twice as many lines in each further replicate: those that planned too few get there in a few of them.
  constexpr uint64_t kMostDoublings = 6;
  const uint64_t further = std::max<uint64_t>(sums_.replicateCount(), options_.replicates) - options_.replicates;
  const LineCounts counts =
      lines_.count(sums_.lines->pairs(), replicate, wanting_, 1u << std::min(further, kMostDoublings));
  PairCounts common;
  if (options_.directions)
    common = engine_.count(sampleDirections(options_.sampler, options_.directions, options_.seed, replicate));
  // Only lines that leave the scene or leak are asked for.
  std::erase_if(common, [](const PairCount& count) { return count.j < kEnvironment; });
  if (sums_.replicateCount() == 0) sums_.measure_area = count_area_;
  sums_.addLines(replicate, common, options_.directions, counts);
  measureErrors();
  last_seconds_ = secondsSince(begun);
}

Estimate LineRun::estimate() const { return makeEstimate(sums_, options_.relative_floor); }

}  // namespace viewpeel
