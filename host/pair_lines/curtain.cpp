#include "pair_lines/curtain.h"

#include <cmath>

#include <glm/glm.hpp>

#include "pair_lines/corners.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr int kMostCurtains = 4;  // most curtains tried for a pair

// Returns whether the line from p to q meets a blocker.
bool isOnLine(const Blocker& blocker, const dvec3& p, const dvec3& q) {
  const double from = glm::dot(blocker.normal, p) - blocker.offset, to = glm::dot(blocker.normal, q) - blocker.offset;
  if (!(from * to < 0)) return false;
  const dvec3 x = glm::mix(p, q, from / (from - to));
  for (uint32_t e = 0; e < blocker.corner_count; ++e)
    if (glm::dot(blocker.edge_normals[e], x) > blocker.edge_offsets[e]) return false;
  return true;
}

// Returns a blocker of the list that the line from p to q meets, or UINT32_MAX.
uint32_t findOnLine(const std::vector<Blocker>& blockers, const BlockerList& list, const dvec3& p, const dvec3& q,
                    Vectors vectors) {
  uint32_t found = UINT32_MAX;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        const auto isMet = [&](uint32_t index) __attribute__((always_inline)) {
          const bool is_met = isOnLine(blockers[index], p, q);
          if (is_met) found = index;
          return is_met;
        };
        forEachOnLine<typename Types::Doubles>(list, p, q, 0, isMet);
      });
  return found;
}

}  // namespace

bool Curtain::isCrossedBy(const glm::dvec3& p, const glm::dvec3& q) const {
  bool is_odd = false;
  for (const uint32_t member : members_) {
    const Blocker& blocker = blockers_[member];
    const double from = glm::dot(blocker.normal, p) - blocker.offset, to = glm::dot(blocker.normal, q) - blocker.offset;
    if (std::min(from, to) > kTouchingShaft || std::max(from, to) < -kTouchingShaft) continue;
    const bool is_across = std::min(from, to) < -kTouchingShaft && std::max(from, to) > kTouchingShaft;
    if (!is_across) return false;
    const glm::dvec3 x = glm::mix(p, q, from / (from - to));
    double beyond = -INFINITY;
    for (uint32_t e = 0; e < blocker.corner_count; ++e)
      beyond = std::max(beyond, glm::dot(blocker.edge_normals[e], x) - blocker.edge_offsets[e]);
    if (std::abs(beyond) <= kTouchingShaft) return false;
    is_odd ^= beyond < 0;
  }
  return is_odd;
}

bool Curtain::hides(const Patch& a, const Patch& b, const PatchShaft& shaft, std::span<const uint32_t> between,
                    Vectors vectors) {
  if (between.size() < 2 || !shaft.areLinesBlocked(blockers_, between, vectors)) return false;
  const auto isOutside = [&](const std::array<dvec3, 2>& ends) { return shaft.isOutside(ends); };
  const auto isApart = [&](const Blocker& blocker) { return areApart(a, blocker) && areApart(b, blocker); };
  // One line between the patches has to cross the curtain. The line between their middles is tried first. A
  // second one serves where the first meets an edge.
  int tries = 0;
  for (const double to_corner : {0.0, 0.4}) {
    const dvec3 p = glm::mix(a.middle, a.corners[0], to_corner), q = glm::mix(b.middle, b.corners[1], to_corner);
    if (glm::dot(a.normal, q) <= a.offset || glm::dot(b.normal, p) <= b.offset) continue;
    for (const uint32_t first : between) {
      if (tries == kMostCurtains) return false;
      if (!isOnLine(blockers_[first], p, q)) continue;
      if (grow(first, isOutside, isApart) && isCrossedBy(p, q)) return true;
      ++tries;
    }
  }
  return false;
}

bool Curtain::hides(const Patch& a, const Box& b, const Shaft& shaft, const BlockerList& between, Vectors vectors) {
  if (between.size() < 2) return false;
  // The first line runs beside the middles, for in tidy scenes a line between them often meets an edge.
  const dvec3 p = glm::mix(a.middle, a.corners[0], 0.137), q = glm::mix(b.low, b.high, 0.537);
  const auto isInFront = [&](const dvec3& x) { return glm::dot(a.normal, x) > a.offset; };
  if (!isInFront(q)) return false;
  const uint32_t first = findOnLine(blockers_, between, p, q, vectors);
  if (first == UINT32_MAX) return false;
  // Most boxes are not hidden. A clear line to a corner of either end shows this sooner than a curtain that fails. The
  // blocker of one line often stops the next.
  uint32_t last = first;
  const auto isBlocked = [&](const dvec3& start, const dvec3& end) {
    if (isOnLine(blockers_[last], start, end)) return true;
    const uint32_t found = findOnLine(blockers_, between, start, end, vectors);
    if (found != UINT32_MAX) last = found;
    return found != UINT32_MAX;
  };
  for (int k = 0; k < 8; ++k) {
    const dvec3 corner = cornerOf(b, k);
    if (isInFront(corner) && !isBlocked(p, corner)) return false;
  }
  for (uint32_t k = 0; k < a.corner_count; ++k)
    if (!isBlocked(a.corners[k], q)) return false;
  const auto isOutside = [&](const std::array<dvec3, 2>& ends) { return shaft.isOutside(ends); };
  const auto isApart = [&](const Blocker& blocker) { return areApart(a, blocker) && areApart(b, blocker); };
  return grow(first, isOutside, isApart) && isCrossedBy(p, q);
}

}  // namespace viewpeel
