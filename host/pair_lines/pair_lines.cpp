#include "pair_lines/pair_lines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

#include <viewpeel/error.h>
#include "directions/replicates.h"
#include "hash.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr size_t kMostChunk = 64;         // pairs that a thread takes at once,
constexpr size_t kChunks = 16;            // so that each thread takes about this many chunks
constexpr size_t kUniformChunk = 16;      // tasks of independent lines that a thread takes at once
constexpr uint32_t kSampledPairs = 4096;  // for an estimate of all pairs
// Lines are drawn by angles where the unoccluded form factor is above kLarge, or where it is above kLeastNear and the
// gap is below kNear of the smaller patch's diagonal. They also are where, in a pilot by points, a share of the lines
// below kUneven would count in effect, or the lines have less than kMissing of their mean weight, for heavy ones are
// missing.
constexpr double kLarge = 0.3, kLeastNear = 1e-3, kNear = 0.15, kUneven = 0.2, kMissing = 0.5;
constexpr uint32_t kMostPeriod = 8;

bool areNear(const Patch& a, const Patch& b) {
  const glm::dvec3 gap = glm::max(glm::dvec3(0), glm::max(a.low - b.high, b.low - a.high));
  return glm::length(gap) < kNear * std::min(glm::length(a.high - a.low), glm::length(b.high - b.low));
}

}  // namespace

PairLines::PairLines(const Scene& scene, const Ids& face_ids, LeakingFaces leaking, uint64_t seed, size_t threads,
                     std::function<void()> stop, const Device* device, Crew* crew, bool ends_on_blockers)
    : scene_(scene),
      ids_(face_ids),
      leaking_(std::move(leaking)),
      ends_on_blockers_(ends_on_blockers),
      seed_(seed),
      threads_(threads ? threads : threadCount()),
      stop_(std::move(stop)),
      finder_(scene, face_ids, leaking_, ends_on_blockers),
      device_(device),
      crew_(crew) {}

std::vector<LinePair> PairLines::find(double least_form_factor) {
  return crew_ ? findOnRanks(least_form_factor) : findHere(least_form_factor);
}

std::vector<LinePair> PairLines::findHere(double least_form_factor) {
  parts_ = finder_.find(threads_, stop_, least_form_factor);
  const auto idsOf = [&](const PatchPair& part) {
    return std::minmax({finder_.patches()[part.a].id, finder_.patches()[part.b].id});
  };
  if (!std::ranges::is_sorted(parts_.pairs, {}, idsOf)) std::ranges::stable_sort(parts_.pairs, {}, idsOf);
  size_t count = 0;
  for (size_t k = 0; k < parts_.pairs.size(); ++k)
    count += k == 0 || idsOf(parts_.pairs[k]) != idsOf(parts_.pairs[k - 1]);
  std::vector<LinePair> pairs;
  pairs.reserve(count);
  groups_ = {};
  groups_.reserve(count);
  const double unit = scene_.scale * scene_.scale;
  for (uint32_t k = 0; k < parts_.pairs.size(); ++k) {
    const PatchPair& part = parts_.pairs[k];
    const auto [i, j] = idsOf(part);
    if (pairs.empty() || pairs.back().i != i || pairs.back().j != j) {
      pairs.push_back({i, j});
      groups_.push_back({.first = k, .has_back = j >= ids_.count()});
    }
    LinePair& pair = pairs.back();
    ++groups_.back().count;
    pair.exchange += part.exchange * unit;
    pair.error += part.error * unit;
    if (part.blocker_count == 0) pair.clear += part.exchange * unit;
    const Patch &a = finder_.patches()[part.a], &b = finder_.patches()[part.b];
    const double form_factor = part.exchange / std::min(a.area, b.area);
    pair.by_angles |= form_factor > kLarge || (form_factor > kLeastNear && areNear(a, b));
  }
  if (least_form_factor > 0) leaveOut(pairs, least_form_factor);
  forgetClearParts();
  return pairs;
}

// Leaves out pairs of faces whose unoccluded form factor, summed over the parts of both faces, is below the least.
void PairLines::leaveOut(std::vector<LinePair>& pairs, double least_form_factor) {
  size_t kept = 0;
  for (size_t k = 0; k < pairs.size(); ++k) {
    const double area_i = ids_.areas[pairs[k].i % ids_.count()], area_j = ids_.areas[pairs[k].j % ids_.count()];
    if (pairs[k].exchange < least_form_factor * std::min(area_i, area_j)) continue;
    pairs[kept] = pairs[k], groups_[kept++] = groups_[k];
  }
  pairs.resize(kept), groups_.resize(kept);
}

// Forgets the patches of pairs that nothing can block. They have no lines, and most pairs of a large scene are such.
void PairLines::forgetClearParts() {
  size_t partial = 0;
  for (const PatchPair& part : parts_.pairs) partial += part.blocker_count > 0;
  std::vector<PatchPair> kept;
  kept.reserve(static_cast<size_t>(kRoomForCuts * double(partial)));
  for (Group& group : groups_) {
    const auto parts = std::span(parts_.pairs).subspan(group.first, isPartial(group) ? group.count : 0);
    group.first = static_cast<uint32_t>(kept.size()), group.count = static_cast<uint32_t>(parts.size());
    kept.insert(kept.end(), parts.begin(), parts.end());
  }
  parts_.pairs = std::move(kept);
}

PairSample PairLines::samplePairs() const {
  const std::vector<Patch>& patches = finder_.patches();
  const auto isInFront = [](const Patch& of, const Patch& other) {
    return std::ranges::any_of(other.corners, [&](const glm::dvec3& corner) {
      return glm::dot(of.normal, corner) > of.offset + kTouchingShaft;
    });
  };
  std::vector<std::pair<uint32_t, uint32_t>> facing;
  Hash places;
  for (uint32_t k = 0; k < kSampledPairs; ++k) {
    places.add(uint64_t(k));
    const uint64_t place = places.value();
    const auto p = static_cast<uint32_t>((place >> 32) % patches.size()),
               q = static_cast<uint32_t>((place & UINT32_MAX) % patches.size());
    const Patch &a = patches[p], &b = patches[q];
    const bool is_pair = a.id != b.id && mayExchange(a.roles, b.roles);
    if (is_pair && isInFront(a, b) && isInFront(b, a)) facing.emplace_back(p, q);
  }
  PairSample sample;
  sample.each = 0.5 * double(patches.size()) * double(patches.size()) / kSampledPairs;
  sample.facing = facing.size();
  const PairsAmong among = finder_.findAmong(facing, threads_);
  sample.decided = among.decided;
  for (const PatchPair& pair : among.found) {
    const Patch &a = patches[pair.a], &b = patches[pair.b];
    sample.found.push_back({pair.exchange / (ids_.sides() * std::min(a.area, b.area)), pair.blocker_count > 0,
                            a.is_part || b.is_part ? finder_.mostBetweenRows(pair.a, pair.b) : 0});
  }
  return sample;
}

double PairSample::sumOfSmall(double least_form_factor) const {
  double sum = 0;
  for (const Pair& pair : found)
    if (pair.form_factor < least_form_factor) sum += pair.is_blocked ? pair.form_factor / 2 : pair.form_factor;
  return each * sum;
}

PairNumbers PairSample::numbersFor(double least_form_factor) const {
  const auto countOf = [&](const auto& predicate) { return each * double(std::ranges::count_if(found, predicate)); };
  const auto isLarge = [&](const Pair& pair) { return pair.form_factor >= least_form_factor; };
  return {each * double(facing),
          each * double(decided),
          each * double(found.size()),
          countOf(isLarge),
          countOf([](const Pair& pair) { return pair.is_blocked; }),
          countOf([&](const Pair& pair) { return pair.most_of_parts >= least_form_factor && !isLarge(pair); })};
}

PairLinesFigures PairLines::figures() const {
  PairLinesFigures figures;
  figures.blockers = finder_.blockers().size();
  for (const Group& group : groups_)
    if (!group.has_back) ++(isPartial(group) ? figures.partial : figures.clear);
  return figures;
}

std::vector<PairLines::Part> PairLines::blockableParts(size_t pair) const {
  std::vector<Part> found;
  const double unit = scene_.scale * scene_.scale;
  for (uint32_t k = groups_[pair].first; k < groups_[pair].first + groups_[pair].count; ++k)
    if (parts_.pairs[k].blocker_count)
      found.push_back({k, parts_.pairs[k].exchange * unit, parts_.pairs[k].blocker_count});
  return found;
}

UniformLines PairLines::uniformLinesOf(const PatchPair& part) const {
  return {finder_.patches()[part.a], finder_.patches()[part.b], part.exchange, finder_.blockers(), blockersOf(part)};
}

uint64_t PairLines::streamOf(const PatchPair& part, uint64_t series) const {
  Hash stream;
  for (const uint64_t number :
       {seed_, numberOf(finder_.patches()[part.a]), numberOf(finder_.patches()[part.b]), series})
    stream.add(number);
  return stream.value();
}

UniformLineCount PairLines::drawUniform(uint32_t index, uint64_t series, uint64_t lines, double most_candidates,
                                        Vectors vectors) const {
  const PatchPair& part = parts_.pairs[index];
  const UniformLines drawn = uniformLinesOf(part);
  if (drawn.efficiency() * most_candidates < 1) return {.lines = lines, .open = lines};
  return drawn.draw(streamOf(part, series), lines, vectors);
}

VisibilityGuess PairLines::guessVisibility(uint32_t index, uint64_t series, Vectors vectors) const {
  const PatchPair& part = parts_.pairs[index];
  const Patch &a = finder_.patches()[part.a], &b = finder_.patches()[part.b];
  const LineDrawer drawer(a, b, a.plane == b.plane ? LineWay::contact : LineWay::angles, part.exchange,
                          finder_.blockers(), blockersOf(part));
  const DrawnLines lines = drawer.draw(scramblesOf(part, kLineReplicates.first + series), 0, 1, vectors);
  if (!(lines.all > 0)) return {};
  return {static_cast<float>(lines.facing / lines.all), static_cast<float>(lines.all * lines.all / lines.squares)};
}

void PairLines::drawUniformHere(std::span<UniformTask> tasks) const {
  const Vectors vectors = widestVectors();
  shareOut(
      threads_, tasks.size(), kUniformChunk,
      [&](size_t, size_t k) {
        UniformTask& task = tasks[k];
        if (task.lines) task.count += drawUniform(task.part, task.series, task.lines, task.most_candidates, vectors);
        if (task.count.open == task.count.lines) task.guess = guessVisibility(task.part, task.series, vectors);
      },
      [&](size_t) { stopIfRequested(); });
}

void PairLines::drawUniform(std::span<UniformTask> tasks) const {
  crew_ ? drawUniformOnRanks(tasks) : drawUniformHere(tasks);
}

void PairLines::drawStrataHere(std::span<StrataTask> tasks) const {
  const Vectors vectors = widestVectors();
  shareOut(
      threads_, tasks.size(), 1,
      [&](size_t, size_t k) {
        StrataTask& task = tasks[k];
        if (task.cells == 0) return;
        const PatchPair& part = parts_.pairs[task.part];
        const UniformLines lines = uniformLinesOf(part);
        task.sums = lines.drawStrata(streamOf(part, task.series), task.cells, task.share, vectors);
        task.efficiency = lines.efficiency(), task.error = lines.strataError();
      },
      [&](size_t) { stopIfRequested(); });
}

void PairLines::drawStrata(std::span<StrataTask> tasks) const {
  if (tasks.empty()) return;
  crew_ ? drawStrataOnRanks(tasks) : drawStrataHere(tasks);
}

void PairLines::forEach(size_t count, const std::function<void(size_t)>& work) const {
  // A few pairs may need most of the work, so few pairs are shared out in small chunks.
  const size_t chunk = std::clamp<size_t>(count / (threads_ * kChunks), 1, kMostChunk);
  shareOut(
      threads_, count, chunk, [&](size_t, size_t k) { work(k); }, [&](size_t) { stopIfRequested(); });
}

// Returns the largest part of a pair, as a share of all parts that something may block.
double PairLines::largestShareOf(const Group& group) const {
  double largest = 0, all = 0;
  for (uint32_t part = group.first; part < group.first + group.count; ++part)
    if (parts_.pairs[part].blocker_count > 0) {
      largest = std::max(largest, parts_.pairs[part].exchange), all += parts_.pairs[part].exchange;
    }
  return all > 0 ? largest / all : 1;
}

bool PairLines::isPartial(const Group& group) const {
  for (uint32_t part = group.first; part < group.first + group.count; ++part)
    if (parts_.pairs[part].blocker_count > 0) return true;
  return false;
}

bool PairLines::isNear(const Group& group) const {
  for (uint32_t part = group.first; part < group.first + group.count; ++part)
    if (areNear(finder_.patches()[parts_.pairs[part].a], finder_.patches()[parts_.pairs[part].b])) return true;
  return false;
}

// Returns how many lines a pair needs for its goal. A pilot of 16 lines tells, or one of 128 lines where 16 are too few
// to tell. There is no pilot where 16 lines reach the goal for any visibility. A few lines of a near pair may have
// nearly all the weight, so that even 16 lines say nothing.
//   In: goal: standard error of the visibility    Out: pair: by_angles is set where lines by angles are better
double PairLines::findNeed(LinePair& pair, const Group& group, double goal, Vectors vectors) const {
  constexpr double kPilotLines = LineDrawer::kBlockLines;
  if (goal >= 1 || (goal >= kCertainError && !isNear(group))) return kPilotLines;
  const double agreeing = kAgreeingLines * largestShareOf(group) / goal;
  LineSums::PairSum sum;
  std::optional<Drawer> drawer(std::in_place, *this, pair, group);
  const auto pilot = [&](uint32_t first, uint32_t end) {
    for (uint32_t p = first; p < end; ++p)
      LineSums::addTo(sum, drawer->draw(kLineReplicates.first + p, pair.blocks, vectors));
  };
  const auto takeBetterWay = [&](uint32_t pilots) {
    const bool are_even = double(sum.effective) / kEffectiveUnit >= kUneven * pilots * kPilotLines,
               are_all_there = double(sum.all) >= kMissing * pilots * kLineUnit;
    if (pair.by_angles || group.is_cut || (are_even && are_all_there)) return;
    pair.by_angles = true;
    drawer.emplace(*this, pair, group);
    sum = {};
    pilot(0, pilots);
  };
  const auto needOf = [&](double lines) {
    return lines * std::pow(visibilityOf(sum, pair.blocks).variance / (goal * goal), kLineRate);
  };
  pilot(0, 1);
  takeBetterWay(1);
  const double need = needOf(kPilotLines);
  if (need <= kLinePilots * kPilotLines && sum.all > 0) return std::max(need, agreeing);
  pilot(1, kLinePilots);
  takeBetterWay(kLinePilots);
  return std::max(needOf(kLinePilots * kPilotLines), agreeing);
}

void PairLines::plan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed,
                     uint32_t replicates) {
  std::vector<double> goals(pairs.size());
  forEach(pairs.size(), [&](size_t k) { goals[k] = allowed(pairs[k]) / (pairs[k].exchange - pairs[k].clear); });
  planGoals(pairs, goals, replicates);
}

void PairLines::planGoals(std::span<LinePair> pairs, std::span<const double> goals, uint32_t replicates) const {
  crew_ ? planOnRanks(pairs, goals, replicates) : planHere(pairs, 0, goals, replicates);
}

// Plans some of the pairs.    In: pairs: from number `first` on; goals: standard error of each one's visibility, or
// kHasPlan where a pair keeps its plan
void PairLines::planHere(std::span<LinePair> pairs, size_t first, std::span<const double> goals,
                         uint32_t replicates) const {
  const Vectors vectors = widestVectors();
  forEach(pairs.size(), [&](size_t k) {
    if (goals[k] == kHasPlan) return;
    LinePair& pair = pairs[k];
    const Group& group = groups_[first + k];
    pair.blocks = isPartial(group), pair.period = 1;
    if (pair.blocks == 0) return;
    const double lines = findNeed(pair, group, goals[k], vectors),
                 blocks = lines / (LineDrawer::kBlockLines * double(replicates));
    pair.blocks = static_cast<uint32_t>(std::min(double(kMostLineBlocks), std::max(1.0, std::ceil(blocks))));
    while (2 * pair.period <= std::min(kMostPeriod, replicates) && 2 * pair.period * blocks <= 1) pair.period *= 2;
  });
}

}  // namespace viewpeel
