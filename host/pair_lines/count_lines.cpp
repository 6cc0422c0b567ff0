// Draws the lines of pairs, on threads or on a device, and counts those that nothing blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include <viewpeel/error.h>
#include "pair_lines/pair_lines.h"
#include "pair_lines/sobol_points.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr size_t kDeviceChunk = 1 << 16;  // pairs whose tasks are made at once
constexpr size_t kTriedPairs = 64;
// A thread takes this many pairs at once, or fewer where their lines cost more than so many blocks of lines past one
// blocker, which take some 2 ms.
constexpr size_t kTaskPairs = 64;
constexpr double kTaskCost = 5e4;

// Returns the variance of a part's visibility if its lines were independent.
double chanceOf(const DrawnLines& lines) {
  return lines.all > 0 ? varianceByChance(lines.facing / lines.all, lines.all * lines.all / lines.squares) : 0.25;
}

}  // namespace

std::array<uint32_t, 4> PairLines::scramblesOf(const PatchPair& part, uint64_t replicate) const {
  return viewpeel::scramblesOf(
      {seed_, numberOf(finder_.patches()[part.a]), numberOf(finder_.patches()[part.b]), replicate});
}

LineWay PairLines::wayOf(const LinePair& pair, const PatchPair& part) const {
  const std::vector<Patch>& patches = finder_.patches();
  if (patches[part.a].plane == patches[part.b].plane) return LineWay::contact;
  return pair.by_angles ? LineWay::angles : LineWay::points;
}

std::span<const PlacedBlocker> PairLines::blockersOf(const PatchPair& part) const {
  return {&parts_.between[part.first_blocker], part.blocker_count};
}

// Returns the task that draws the lines of one part of a pair.
LineTask PairLines::taskOf(const LinePair& pair, uint32_t part, uint64_t replicate, uint32_t blocks) const {
  const PatchPair& patches = parts_.pairs[part];
  return {.a = patches.a,
          .b = patches.b,
          .way = wayOf(pair, patches),
          .exchange = patches.exchange,
          .between = blockersOf(patches),
          .scrambles = scramblesOf(patches, replicate),
          .end = blocks};
}

// Makes the count of a pair in one replicate from the lines of its parts. In: drawn_of(part): the lines of a part with
// blockers
template <class DrawnOf>
LineCount PairLines::combine(const LinePair& pair, const Group& group, uint32_t blocks, const DrawnOf& drawn_of) const {
  double facing = 0, all = 0, squares = 0, blockable = 0, spread = 0;
  uint32_t parts = 0;
  for (uint32_t k = group.first; k < group.first + group.count; ++k)
    if (parts_.pairs[k].blocker_count) blockable += parts_.pairs[k].exchange;
  for (uint32_t k = group.first; k < group.first + group.count; ++k) {
    if (!parts_.pairs[k].blocker_count) continue;
    const DrawnLines lines = drawn_of(k);
    const double weight = parts_.pairs[k].exchange / blockable;
    facing += weight * lines.facing, all += weight * lines.all, squares += weight * weight * lines.squares;
    spread += weight * weight * chanceOf(lines);
    ++parts;
  }
  // Counts are integers: weights are scaled so that all lines together weigh kLineUnit on average, and rounded.
  const double unit = kLineUnit / (LineDrawer::kBlockLines * double(pair.blocks));
  const double scale = unit * std::min(1.0, kMostLineUnits / std::max(1.0, all * unit));
  LineCount count{0, blocks, 0, 0, 0};
  count.facing = static_cast<uint32_t>(std::lround(facing * scale));
  count.all = static_cast<uint32_t>(std::lround(all * scale));
  if (!(squares > 0)) return count;
  double effective = all * all / squares;
  if (parts > 1) {
    // Parts have strata of the pair's points: so many lines without strata would have the same variance.
    const double by_chance = varianceByChance(facing / all, effective);
    effective = std::max(0.0, by_chance * (effective + 1) / spread - 1);
  }
  count.effective = static_cast<uint32_t>(std::min(4e9, std::round(effective * kEffectiveUnit)));
  return count;
}

PairLines::Drawer::Drawer(const PairLines& lines, const LinePair& pair, const Group& group)
    : lines_(lines), pair_(pair), group_(group) {
  const std::vector<Patch>& patches = lines.finder_.patches();
  for (const PatchPair& part : std::span(lines.parts_.pairs).subspan(group.first, group.count))
    if (part.blocker_count)
      of_parts_.emplace_back(patches[part.a], patches[part.b], lines.wayOf(pair, part), part.exchange,
                             lines.finder_.blockers(), lines.blockersOf(part));
}

LineCount PairLines::Drawer::draw(uint64_t replicate, uint32_t blocks, Vectors vectors) const {
  auto of_part = of_parts_.begin();
  return lines_.combine(pair_, group_, blocks, [&](uint32_t part) {
    return of_part++->draw(lines_.scramblesOf(lines_.parts_.pairs[part], replicate), 0, blocks, vectors);
  });
}

// Opens the device and compares some lines with the processor's; where they differ the processor draws all lines.
void PairLines::openDevice(std::span<const LinePair> pairs, std::span<const LineCount> counts, uint64_t replicate) {
  device_lines_.emplace(*device_, finder_.patches(), finder_.blockers());
  std::vector<LineTask> tasks;
  for (size_t k = 0; k < counts.size(); k += counts.size() / kTriedPairs + 1) {
    const Group& group = groups_[counts[k].pair];
    for (uint32_t part = group.first; part < group.first + group.count; ++part)
      if (parts_.pairs[part].blocker_count) tasks.push_back(taskOf(pairs[counts[k].pair], part, replicate, 1));
  }
  if (!agree(*device_lines_, tasks, finder_.patches(), finder_.blockers())) device_lines_.reset();
}

// Draws the lines of pairs on the device, but for parts with too many blockers.    In, out: counts: `pair` is set
void PairLines::drawOnDevice(std::span<const LinePair> pairs, std::span<LineCount> counts, uint64_t replicate) {
  std::vector<size_t> first_task(counts.size() + 1);
  for (size_t k = 0; k < counts.size(); ++k) {
    const Group& group = groups_[counts[k].pair];
    first_task[k + 1] = first_task[k];
    for (uint32_t part = group.first; part < group.first + group.count; ++part)
      first_task[k + 1] += parts_.pairs[part].blocker_count > 0;
  }
  std::vector<LineTask> tasks(first_task.back());
  const Vectors vectors = widestVectors();
  std::vector<DrawnLines> on_host(tasks.size());
  forEach(counts.size(), [&](size_t k) {
    const Group& group = groups_[counts[k].pair];
    size_t at = first_task[k];
    for (uint32_t part = group.first; part < group.first + group.count; ++part) {
      if (!parts_.pairs[part].blocker_count) continue;
      LineTask& task = tasks[at];
      task = taskOf(pairs[counts[k].pair], part, replicate, counts[k].blocks);
      if (!DeviceLines::takes(task)) {
        on_host[at] = drawOnHost(task, finder_.patches(), finder_.blockers(), vectors);
        task.between = {}, task.end = task.first;
      }
      ++at;
    }
  });
  const std::vector<DrawnLines> drawn = device_lines_->draw(tasks, stop_);
  forEach(counts.size(), [&](size_t k) {
    const uint32_t pair = counts[k].pair;
    size_t at = first_task[k];
    counts[k] = combine(pairs[pair], groups_[pair], counts[k].blocks, [&](uint32_t) {
      const DrawnLines& lines = on_host[at].lines ? on_host[at] : drawn[at];
      ++at;
      return lines;
    });
    counts[k].pair = pair;
  });
}

// Draws on the device. Returns false where the device rounds otherwise or lacks memory; then it is not used again.
bool PairLines::tryDevice(std::span<const LinePair> pairs, LineCounts& counts, uint64_t replicate) {
  try {
    if (!device_lines_) openDevice(pairs, counts, replicate);
    for (size_t first = 0; device_lines_ && first < counts.size(); first += kDeviceChunk)
      drawOnDevice(pairs, std::span(counts).subspan(first, std::min(kDeviceChunk, counts.size() - first)), replicate);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::memory) throw;
    device_lines_.reset();
  }
  if (!device_lines_) device_ = nullptr;
  return device_lines_.has_value();
}

LineCounts PairLines::count(std::span<const LinePair> pairs, uint64_t replicate, std::span<const uint32_t> times) {
  return crew_ ? countOnRanks(pairs, replicate, times) : countHere(pairs, {0, pairs.size()}, replicate, times);
}

// Counts some of the pairs.    In: range: of their numbers; times: of all pairs, or empty
LineCounts PairLines::countHere(std::span<const LinePair> pairs, std::pair<size_t, size_t> range, uint64_t replicate,
                                std::span<const uint32_t> times) {
  LineCounts counts;
  for (auto k = static_cast<uint32_t>(range.first); k < range.second; ++k)
    if (times.empty() ? pairs[k].hasLines(replicate) : pairs[k].blocks && times[k])
      counts.push_back({k, std::min(pairs[k].blocks * (times.empty() ? 1 : times[k]), kMostLineBlocks), 0, 0, 0});
  if (device_ && tryDevice(pairs, counts, replicate)) return counts;
  return std::move(drawOnThreads(pairs, counts, replicate, 1, !times.empty())[0]);
}

std::vector<LineCounts> PairLines::countAhead(std::span<const LinePair> pairs, uint64_t replicate, size_t replicates) {
  if (crew_ || device_) {
    std::vector<LineCounts> all;
    for (size_t r = 0; r < replicates; ++r) all.push_back(count(pairs, replicate + r));
    return all;
  }
  LineCounts due;
  for (uint32_t k = 0; k < pairs.size(); ++k)
    if (pairs[k].blocks) due.push_back({k, pairs[k].blocks, 0, 0, 0});
  return drawOnThreads(pairs, due, replicate, replicates, false);
}

// Draws the lines of several replicates on threads.
//   In: due: the pairs, with their blocks in a replicate; is_further: whether a pair has lines in all these replicates,
//   and not only in those of its period    Out: counts of each replicate, in the order of `due`
std::vector<LineCounts> PairLines::drawOnThreads(std::span<const LinePair> pairs, const LineCounts& due,
                                                 uint64_t replicate, size_t replicates, bool is_further) const {
  // A Task draws the lines of a range of `due` in a range of the replicates.
  struct Task {
    size_t first, end, first_replicate, end_replicate;
    double cost;
    std::vector<LineCounts> counts;  // by replicate
  };
  // A few pairs may need most of the lines. Each of them is a task of its own in each replicate.
  std::vector<Task> tasks;
  for (size_t k = 0; k < due.size(); ++k) {
    const double cost = costOf(groups_[due[k].pair]) * due[k].blocks;
    if (cost >= kTaskCost)
      for (size_t r = 0; r < replicates; ++r) tasks.push_back({k, k + 1, r, r + 1, cost, {}});
    else if (tasks.empty() || tasks.back().cost >= kTaskCost || tasks.back().end - tasks.back().first == kTaskPairs)
      tasks.push_back({k, k + 1, 0, replicates, cost * double(replicates), {}});
    else tasks.back().end = k + 1, tasks.back().cost += cost * double(replicates);
  }
  std::vector<size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](size_t t) { return tasks[t].cost; });
  const Vectors vectors = widestVectors();
  shareOut(
      threads_, order.size(), 1,
      [&](size_t, size_t at) {
        Task& task = tasks[order[at]];
        task.counts.resize(task.end_replicate - task.first_replicate);
        for (size_t k = task.first; k < task.end; ++k) {
          const LinePair& pair = pairs[due[k].pair];
          const Drawer drawer(*this, pair, groups_[due[k].pair]);
          for (size_t r = task.first_replicate; r < task.end_replicate; ++r) {
            if (!is_further && !pair.hasLines(replicate + r)) continue;
            LineCount count = drawer.draw(replicate + r, due[k].blocks, vectors);
            count.pair = due[k].pair;
            task.counts[r - task.first_replicate].push_back(count);
          }
        }
      },
      [&](size_t) { stopIfRequested(); });
  std::vector<LineCounts> all(replicates);
  for (Task& task : tasks) {
    for (size_t r = task.first_replicate; r < task.end_replicate; ++r) {
      const LineCounts& counts = task.counts[r - task.first_replicate];
      all[r].insert(all[r].end(), counts.begin(), counts.end());
    }
    task.counts = {};
  }
  return all;
}

}  // namespace viewpeel
