#include "pair_lines/cut_pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

#include <glm/glm.hpp>

namespace viewpeel {
namespace {

using glm::dvec3;

// Returns about what two patches exchange with nothing in between, from lines between 4 points of each. Parts are put
// in order by it, and nothing else depends on it.
double roughExchange(const Patch& a, const Patch& b) {
  constexpr double kToMiddle = 0.4;
  double sum = 0;
  for (const dvec3& corner_a : a.corners)
    for (const dvec3& corner_b : b.corners) {
      const dvec3 p = glm::mix(corner_a, a.middle, kToMiddle), d = glm::mix(corner_b, b.middle, kToMiddle) - p;
      const double out = glm::dot(a.normal, d), in = -glm::dot(b.normal, d), square = glm::dot(d, d);
      if (out > 0 && in > 0) sum += out * in / (square * square);
    }
  return std::min(sum / 16 * a.area * b.area / std::numbers::pi, std::min(a.area, b.area));
}

bool haveFrontsTowardsEachOther(const Patch& a, const Patch& b) {
  const auto isInFront = [](const Patch& of, const Patch& other) {
    return std::ranges::any_of(other.corners,
                               [&](const dvec3& corner) { return glm::dot(of.normal, corner) > of.offset; });
  };
  return isInFront(a, b) && isInFront(b, a);
}

}  // namespace

// Finds the blockers of a part among the blockers of the part from which it was cut. Returns whether the part is not
// hidden.
bool PairCutter::keepBlockers(CutPart& part, std::span<const PlacedBlocker> from) {
  const std::vector<Blocker>& blockers = finder_.blockers();
  list_.clear(from.size());
  for (const PlacedBlocker& placed : from) {
    const Blocker& blocker = blockers[placed.blocker];
    if (placed.place == BlockerPlace::between) {
      list_.add(placed.blocker, blocker);
      continue;
    }
    const Patch& end = placed.place == BlockerPlace::over_first ? part.a : part.b;
    if (covers(blocker, end)) return false;
    if (overlaps(blocker, end)) part.between.push_back(placed);
  }
  list_.close();
  between_.clear();
  PatchShaft shaft(part.a, part.b);
  if (shaft.isHidden(blockers, list_, between_, vectors_)) return false;
  if (curtain_.hides(part.a, part.b, shaft, between_, vectors_)) return false;
  for (const uint32_t k : between_) part.between.push_back({k, BlockerPlace::between});
  return true;
}

std::vector<CutPart> PairCutter::cut(std::vector<CutPart> parts, uint32_t cuts) {
  std::vector<CutPart> done;
  std::vector<CutPart> waiting;
  std::priority_queue<std::pair<double, size_t>> largest;  // exchange, and index into `waiting`
  const auto add = [&](CutPart&& part) {
    if (part.between.empty() || part.a.plane == part.b.plane) {
      done.push_back(std::move(part));
      return;
    }
    largest.emplace(roughExchange(part.a, part.b), waiting.size());
    waiting.push_back(std::move(part));
  };
  for (CutPart& part : parts) add(std::move(part));
  for (; cuts > 0 && !largest.empty(); --cuts) {
    const CutPart whole = std::move(waiting[largest.top().second]);
    largest.pop();
    const bool cuts_a = lengthOf(whole.a) >= lengthOf(whole.b);
    for (const Patch& half : halvesOf(cuts_a ? whole.a : whole.b)) {
      CutPart part{cuts_a ? half : whole.a, cuts_a ? whole.b : half, whole.whole_a, whole.whole_b, {}};
      if (haveFrontsTowardsEachOther(part.a, part.b) && keepBlockers(part, whole.between)) add(std::move(part));
    }
  }
  for (; !largest.empty(); largest.pop()) done.push_back(std::move(waiting[largest.top().second]));
  return done;
}

}  // namespace viewpeel
