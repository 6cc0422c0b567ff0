#include "estimator/line_run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include <viewpeel/error.h>
#include "rays/ray_engine.h"
#include "sums/pair_walk.h"
#include "sums/pair_blocks.h"
#include "threads.h"

namespace viewpeel {
namespace {

// A run ends short of its goal after this multiple of its planned replicates, for errors may stay as they are where the
// weights of a pair's lines are very uneven.
constexpr uint64_t kMostReplicateGrowth = 8;
// The same where only rows that miss the goal have further rays, or where the time is the goal.
constexpr uint64_t kLargeReplicateGrowth = 64;
// Lines of several replicates are drawn at once where they are at most this many, which takes some 5 s of CPU time, and
// have at most this many counts, 200 MB.
constexpr double kMostLinesAhead = 1e8, kMostCountsAhead = 8e6;
// The same of rays, which take some 2 s of CPU time and have at most as many counts, 500 MB.
constexpr double kMostRaysAhead = 2e7;
// Replicates of rays are counted together where they have at most this many directions in all. Where a replicate has
// many directions, polygons have many rays in it, and counting more replicates at once saves no time.
constexpr size_t kMostDirectionsTogether = 1 << 16;

RunSums lineSumsToBeginWith(const Scene& scene, const Ids& face_ids, std::vector<LinePair> pairs,
                            double least_form_factor, const LeakingFaces& leaking, const EstimateOptions& options) {
  RunSums sums = makeRunSums(scene, face_ids);
  if (options.rays) sums.countRays(options.rays->rays());
  if (!options.resumed) {
    sums.lines.emplace(face_ids, options.by, std::move(pairs), least_form_factor, leaking);
    return sums;
  }
  const LineSums& resumed = *options.resumed->lines;
  sums.lines.emplace(face_ids, options.by, resumed.pairs(), resumed.leastFormFactor(), resumed.leakingFaces());
  return sums;
}

// Leaves out counts of pairs that have lines, or of all pairs where each has.
void leaveOutPairsWithLines(PairCounts& counts, const LineSums& lines) {
  if (lines.leastFormFactor() == 0) {
    std::erase_if(counts, [](const PairCount& count) { return count.j < kEnvironment; });
    return;
  }
  const RowRanges ranges(lines.ids().count());
  std::vector<std::span<PairCount>> left(ranges.count());
  shareOut(threadsFor(counts.size()), left.size(), 1, [&](size_t, size_t k) {
    PairWalk with_lines(ranges.of(lines.pairs(), k));
    const std::span<const PairCount> of_range = ranges.of(counts, k);
    const auto first = counts.begin() + (of_range.data() - counts.data());
    auto end = first;
    for (const PairCount& count : of_range)
      if (!with_lines.find(count)) *end++ = count;
    left[k] = {first, end};
  });
  auto end = counts.begin();
  for (const std::span<PairCount> of_range : left) end = std::ranges::move(of_range, end).out;
  counts.erase(end, counts.end());
}

}  // namespace

LineRun::LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
                 double least_form_factor, EstimateOptions options)
    : engine_(engine),
      lines_(lines),
      options_(std::move(options)),
      count_area_(options_.directions ? engine.unitArea() * scene.scale * scene.scale / options_.directions : 0),
      sums_(lineSumsToBeginWith(scene, face_ids, std::move(pairs), least_form_factor, lines.leakingFaces(), options_)),
      errors_in_goal_(sumsOfRows().ids().count()) {
  if (options_.replicates < 2) throw Error(ErrorCode::bad_usage, "a standard error needs at least 2 replicates");
  if (options_.resumed) {
    sums_.add(*options_.resumed);
    resumed_count_ = sums_.replicateCount();
    measureErrors();
  }
}

// Returns whether there may be replicates beyond the planned ones.
bool LineRun::mayGoOn() const {
  const bool casts_rays = hasFurtherRays() && (hasCountedPairs() || needs_directions_);
  const uint64_t growth = casts_rays || options_.is_timed ? kLargeReplicateGrowth : kMostReplicateGrowth;
  return sums_.replicateCount() < growth * options_.replicates;
}

// Returns the seconds that the next replicate is expected to take.
double LineRun::secondsOfNext() const {
  const uint64_t done = sums_.replicateCount();
  const double mean = secondsSince(start_) / std::max(double(done - resumed_count_), 1.0);
  if (!is_further_ || (hasCountedPairs() && needs_directions_)) return mean;
  return mean * furtherLines() / std::max(double(sums_.lines->lineCount()) / double(done), 1.0);
}

bool LineRun::isDone() const {
  const uint64_t done = sums_.replicateCount();
  if (options_.seconds && done >= 2 && done > resumed_count_ && secondsOfNext() > secondsLeft()) return true;
  // Where the time is the goal, counted pairs, environment and leak gain from each further replicate.
  const bool goes_on = options_.is_timed && hasCountedPairs() && mayGoOn();
  return done >= options_.replicates && (options_.is_exact || (!is_further_ && !goes_on));
}

// Returns the number of further lines in the next replicate.
double LineRun::furtherLines() const {
  double lines = 0;
  for (size_t k = 0; k < further_.size(); ++k)
    lines += further_[k] * sums_.lines->pairs()[k].linesIn(1) * sums_.lines->pairs()[k].period;
  return lines;
}

double LineRun::mostAhead() const {
  double lines = 0, counts = 0;
  for (const LinePair& pair : sums_.lines->pairs()) {
    lines += pair.linesIn(1);
    if (pair.blocks) counts += 1.0 / pair.period;
  }
  double most = std::min(kMostLinesAhead / std::max(lines, 1.0), kMostCountsAhead / std::max(counts, 1.0));
  if (options_.rays)
    most = std::min({most, kMostRaysAhead / options_.rays->raysOfReplicate(options_.directions),
                     double(kMostDirectionsTogether) / options_.directions});
  return std::max(most, 1.0);
}

// Returns how many of the planned replicates are drawn at once next. Where there is a time limit, the first replicate
// tells how many more fit.
size_t LineRun::replicatesAhead() const {
  const uint64_t done = sums_.replicateCount();
  if (done >= options_.replicates || (options_.seconds && done == resumed_count_)) return 1;
  double most = mostAhead();
  if (options_.seconds) most = std::min(most, secondsLeft() / secondsOfNext());
  return static_cast<size_t>(std::clamp(most, 1.0, double(options_.replicates - done)));
}

void LineRun::step() {
  const uint64_t replicate = options_.first_replicate + sums_.replicateCount();
  if (is_further_) ahead_.assign(1, {lines_.count(sums_.lines->pairs(), replicate, further_), std::nullopt});
  else if (ahead_.empty()) drawAhead(replicate);
  if (is_further_ && hasFurtherRays()) castFurtherRays(replicate, ahead_.front().lines);
  else addReplicate(replicate, ahead_.front());
  ahead_.pop_front();
  measureErrors();
}

// Draws the lines of the next planned replicates, and their rays: rays of several replicates take less time together.
void LineRun::drawAhead(uint64_t replicate) {
  const size_t replicates = replicatesAhead();
  std::vector<LineCounts> lines = lines_.countAhead(sums_.lines->pairs(), replicate, replicates);
  for (LineCounts& of_replicate : lines) ahead_.push_back({std::move(of_replicate), std::nullopt});
  if (!options_.rays) return;
  std::vector<PairCounts> rays = countReplicates(replicate, replicates);
  for (size_t k = 0; k < replicates; ++k) ahead_[k].counts = std::move(rays[k]);
}

// Adds a replicate. Common directions are counted first, and rays that were not drawn ahead.
void LineRun::addReplicate(uint64_t replicate, Ahead& drawn) {
  PairCounts counts;
  if (drawn.counts) counts = std::move(*drawn.counts);
  else if (options_.directions) counts = std::move(countReplicates(replicate, 1).front());
  leaveOutPairsWithLines(counts, *sums_.lines);
  if (sums_.replicateCount() == 0) sums_.measure_area = count_area_;
  sums_.addLines(replicate, counts, options_.directions, drawn.lines);
}

// Adds replicates in which only the rows that miss the goal have rays. The first one has the lines.
void LineRun::castFurtherRays(uint64_t replicate, const LineCounts& lines) {
  const uint32_t most = std::max(1u, std::ranges::max(further_rays_)),
                 together = std::max(1u, static_cast<uint32_t>(kMostDirectionsTogether / options_.directions));
  const Ids& faces = sums_.by_id.ids();
  std::vector<PairCounts> counts;
  for (uint32_t first = 0; first < most; first += together) {
    const uint32_t count = std::min(together, most - first);
    std::vector<uint32_t> blocks;
    for (uint32_t face = 0; face < faces.count(); ++face) {
      const uint32_t replicates = further_rays_[options_.by == By::polygon ? face : faces.surface[face]];
      blocks.push_back(std::clamp(replicates, first, first + count) - first);
    }
    std::ranges::move(options_.rays->countOutside(directionsOf(replicate + first, count), options_.directions, blocks),
                      std::back_inserter(counts));
  }
  for (uint32_t k = 0; k < most; ++k) {  // comes last, for counting may be stopped
    std::vector<bool> rows;
    for (const uint32_t replicates : further_rays_) rows.push_back(k < replicates);
    sums_.addOutside(replicate + k, counts[k], options_.directions, k == 0 ? lines : LineCounts(), rows);
  }
}

// Returns the directions of replicates, one after another.    In: replicate: the first
std::vector<Direction> LineRun::directionsOf(uint64_t replicate, size_t replicates) const {
  return sampleReplicates(options_.sampler, options_.directions, options_.seed, replicate, replicates);
}

// Counts replicates, one after another. Rays count only what leaves the scene or ends on backs where all pairs have
// lines.    In: replicate: the first
std::vector<PairCounts> LineRun::countReplicates(uint64_t replicate, size_t replicates) const {
  const std::vector<Direction> directions = directionsOf(replicate, replicates);
  if (options_.rays && !hasCountedPairs())
    return options_.rays->countOutside(directions, options_.directions,
                                       blocksOfRequested(sums_.lines->ids(), replicates));
  // Threads share the directions in count(), but may share the blocks in countBlocks().
  return replicates == 1 ? std::vector<PairCounts>{engine_.count(directions)}
                         : engine_.countBlocks(directions, options_.directions);
}

Estimate LineRun::estimate() const { return makeEstimate(sums_, options_.relative_floor); }

}  // namespace viewpeel
