// This file cuts the pairs of PairLines that need many lines.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "pair_lines/cut_pairs.h"
#include "pair_lines/pair_lines.h"
#include "threads.h"

namespace viewpeel {
namespace {

// A pair with N lines is cut (N / kLinesOfCut)^kCutPower times. A cut costs about as much as 300 lines. With c cuts N
// falls as c^-0.73, as measured in a city of 61 polygons. The sum of both costs, 300 c + N c^-0.73, is least there.
constexpr double kLinesOfCut = 400, kCutPower = 0.58;
constexpr double kFewestCuts = 4;  // fewer cuts pay too little

// Returns a scene whose polygons are these patches, in their order, for their unoccluded form factors.
Scene sceneOf(const Scene& scene, std::span<const Patch> patches) {
  Scene found;
  for (const Patch& patch : patches) {
    Polygon polygon = scene.polygons[patch.side / 2];
    polygon.first_corner = static_cast<uint32_t>(found.corners.size());
    found.corners.insert(found.corners.end(), patch.corners, patch.corners + patch.corner_count);
    polygon.area = patch.area;
    found.polygons.push_back(polygon);
  }
  return found;
}

}  // namespace

// Sets LinePair::cuts of pairs that need many lines.    Out: whether there are any
bool PairLines::chooseCuts(std::span<LinePair> pairs, uint32_t replicates) const {
  const auto isCuttable = [&](const Group& group) {
    const auto parts = std::span(parts_.pairs).subspan(group.first, group.count);
    return std::ranges::any_of(parts, [&](const PatchPair& part) {
      return part.blocker_count > 0 && finder_.patches()[part.a].plane != finder_.patches()[part.b].plane;
    });
  };
  std::vector<double> cuts(pairs.size(), 0);
  double all = 0;
  for (size_t k = 0; k < pairs.size(); ++k) {
    const double wanted = std::pow(pairs[k].linesIn(replicates) / kLinesOfCut, kCutPower);
    if (!(wanted >= kFewestCuts) || groups_[k].is_cut || !isCuttable(groups_[k])) continue;
    cuts[k] = wanted, all += wanted;
  }
  const double share = std::min(1.0, kMostCuts / all);
  bool are_any = false;
  for (size_t k = 0; k < pairs.size(); ++k) {
    if (share * cuts[k] < kFewestCuts) continue;
    pairs[k].cuts = static_cast<uint32_t>(share * cuts[k]);
    are_any = true;
  }
  return are_any;
}

std::vector<CutPart> PairLines::blockedPartsOf(const Group& group) const {
  std::vector<CutPart> parts;
  for (const PatchPair& part : std::span(parts_.pairs).subspan(group.first, group.count)) {
    if (part.blocker_count == 0) continue;
    const auto between = std::span(parts_.between).subspan(part.first_blocker, part.blocker_count);
    parts.push_back({finder_.patches()[part.a], finder_.patches()[part.b], part.a, part.b, {}});
    parts.back().between.assign(between.begin(), between.end());
  }
  return parts;
}

// Replaces the blocked parts of one pair.    In: cut_parts: without blockers; blockers: of each
void PairLines::replaceParts(LinePair& pair, Group& group, std::span<const PatchPair> cut_parts,
                             std::span<const CutPart> blockers) {
  const Group whole = group;
  group.first = static_cast<uint32_t>(parts_.pairs.size()), group.is_cut = true;
  for (uint32_t k = whole.first; k < whole.first + whole.count; ++k)
    if (parts_.pairs[k].blocker_count == 0) parts_.pairs.push_back(PatchPair(parts_.pairs[k]));
  for (size_t k = 0; k < cut_parts.size(); ++k) {
    if (!(cut_parts[k].exchange > 0)) continue;
    PatchPair& part = parts_.pairs.emplace_back(cut_parts[k]);
    part.first_blocker = static_cast<uint32_t>(parts_.between.size());
    part.blocker_count = static_cast<uint32_t>(blockers[k].between.size());
    parts_.between.insert(parts_.between.end(), blockers[k].between.begin(), blockers[k].between.end());
  }
  group.count = static_cast<uint32_t>(parts_.pairs.size()) - group.first;
  pair.exchange = pair.clear = pair.error = 0, pair.parts = 0;
  const double unit = scene_.scale * scene_.scale;
  for (const PatchPair& part : std::span(parts_.pairs).subspan(group.first, group.count)) {
    pair.exchange += part.exchange * unit, pair.error += part.error * unit;
    if (part.blocker_count == 0) pair.clear += part.exchange * unit;
    else ++pair.parts;
  }
}

// Makes pairs whole whose cuts have been taken back.
void PairLines::makeWhole(std::span<LinePair> pairs) {
  std::erase_if(wholes_, [&](const auto& at) {
    LinePair& pair = pairs[at.first];
    if (pair.cuts > 0) return false;
    const LinePair& whole = at.second.pair;
    pair.exchange = whole.exchange, pair.clear = whole.clear, pair.error = whole.error, pair.parts = whole.parts;
    groups_[at.first] = at.second.group;
    return true;
  });
}

void PairLines::cutHere(std::span<LinePair> pairs) {
  makeWhole(pairs);
  std::vector<uint32_t> due;  // indices of pairs
  for (uint32_t k = 0; k < pairs.size(); ++k)
    if (pairs[k].cuts > 0 && !groups_[k].is_cut) due.push_back(k);
  if (due.empty()) return;
  std::vector<std::vector<CutPart>> parts(due.size());
  std::vector<std::optional<PairCutter>> cutters(threads_);
  shareOut(
      threads_, due.size(), 1,
      [&](size_t thread, size_t k) {
        if (!cutters[thread]) cutters[thread].emplace(finder_);
        parts[k] = cutters[thread]->cut(blockedPartsOf(groups_[due[k]]), pairs[due[k]].cuts);
      },
      [&](size_t) { stopIfRequested(); });

  // Patches that are parts of others get places among the finder's, and in a scene for unoccluded form factors.
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> places;  // of the whole patch and Patch::cut: index into `used`
  std::vector<Patch> used;
  std::vector<uint32_t> indices;  // of `used`, among the finder's patches
  const auto placeOf = [&](const Patch& patch, uint32_t whole) {
    const auto [at, is_new] = places.try_emplace({whole, patch.cut}, static_cast<uint32_t>(used.size()));
    if (is_new) {
      used.push_back(patch);
      indices.push_back(patch.cut == 1 ? whole : finder_.add(patch));
    }
    return at->second;
  };
  std::vector<std::vector<PatchPair>> pairs_of_patches(due.size());
  for (size_t k = 0; k < due.size(); ++k)
    for (const CutPart& part : parts[k])
      pairs_of_patches[k].push_back({placeOf(part.a, part.whole_a), placeOf(part.b, part.whole_b)});
  const HostUnoccluded unoccluded(sceneOf(scene_, used), threads_);
  std::vector<UnoccludedWork> works(threads_);
  shareOut(threads_, due.size(), 1, [&](size_t thread, size_t k) {
    for (PatchPair& part : pairs_of_patches[k]) {
      const SidePair sides{2 * part.a + used[part.a].side % 2, 2 * part.b + used[part.b].side % 2};
      const HostUnoccluded::Found found = unoccluded.findClosely(sides, works[thread]);
      part = {indices[part.a], indices[part.b], found.area, found.error};
    }
  });
  for (const uint32_t k : due) wholes_.emplace(k, Whole{pairs[k], groups_[k]});
  for (size_t k = 0; k < due.size(); ++k) replaceParts(pairs[due[k]], groups_[due[k]], pairs_of_patches[k], parts[k]);
}

void PairLines::cutAndPlan(std::span<LinePair> pairs, const std::function<double(const LinePair&)>& allowed,
                           uint32_t replicates) {
  if (!chooseCuts(pairs, replicates)) return;
  std::vector<std::pair<uint32_t, LinePair>> whole;
  for (uint32_t k = 0; k < pairs.size(); ++k)
    if (pairs[k].cuts > 0) whole.emplace_back(k, pairs[k]);
  cut(pairs);
  std::vector<double> goals(pairs.size(), kHasPlan);
  for (const auto& [k, pair] : whole) goals[k] = allowed(pairs[k]) / (pairs[k].exchange - pairs[k].clear);
  planGoals(pairs, goals, replicates);
  const auto pays = [&](const auto& at) { return pairs[at.first].linesIn(replicates) < at.second.linesIn(replicates); };
  std::erase_if(whole, pays);
  if (whole.empty()) return;
  for (const auto& [k, pair] : whole) pairs[k] = pair, pairs[k].cuts = 0;
  cut(pairs);
}

}  // namespace viewpeel
