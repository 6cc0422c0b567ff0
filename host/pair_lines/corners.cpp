#include "pair_lines/corners.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

#include "scene/coincident.h"

namespace viewpeel {
namespace {

using glm::dvec3;

// Blockers in a patch's own plane do not hide it; they are nearer to it than this. A box does not say in which planes
// its patches lie. So a blocker counts only where it is farther than this from the box.
constexpr double kInPlane = 2 * kCoincidenceReach;

}  // namespace

Corners::Corners(const Box& a, const Box& b) : count_(8), middles_{0.5 * (a.low + a.high), 0.5 * (b.low + b.high)} {
  for (int k = 0; k < 8; ++k)
    for (int axis = 0; axis < 3; ++axis)
      first_[axis][k] = cornerOf(a, k)[axis], second_[axis][k] = cornerOf(b, k)[axis];
}

Corners::Corners(const Patch& a, const Box& b) : count_(4), middles_{a.middle, 0.5 * (b.low + b.high)} {
  for (int k = 0; k < 8; ++k)
    for (int axis = 0; axis < 3; ++axis)
      first_[axis][k] = a.corners[k % 4][axis], second_[axis][k] = cornerOf(b, k)[axis];
}

template <class Doubles>
[[gnu::always_inline]] inline bool Corners::areHiddenBy(const Blocker& blocker) const {
  Doubles first[3], second[3];
  for (int axis = 0; axis < 3; ++axis)
    first[axis] = load<Doubles>(first_[axis]), second[axis] = load<Doubles>(second_[axis]);
  const Doubles from = heightsOverPlane(first, blocker), to = heightsOverPlane(second, blocker);
  const auto isAbove = [](const Doubles& heights) __attribute__((always_inline)) {
    return !isAnyAtMost<Doubles>(heights, kInPlane);
  };
  const auto isBelow = [](const Doubles& heights) __attribute__((always_inline)) {
    return areAllAtMost<Doubles>(heights, -kInPlane);
  };
  const bool is_between = (isAbove(from) && isBelow(to)) || (isBelow(from) && isAbove(to));
  if (!is_between) return false;
  for (int i = 0; i < count_; ++i) {
    const double p[3] = {first_[0][i], first_[1][i], first_[2][i]}, height = from[i];
    const Doubles t = height / (height - to), x = p[0] + t * (second[0] - p[0]), y = p[1] + t * (second[1] - p[1]),
                  z = p[2] + t * (second[2] - p[2]);
    Doubles beyond = -INFINITY;
    for (uint32_t e = 0; e < blocker.corner_count; ++e) {
      const dvec3& m = blocker.edge_normals[e];
      beyond = greatest(beyond, m.x * x + m.y * y + m.z * z - blocker.edge_offsets[e]);
    }
    if (!areAllAtMost<Doubles>(beyond, 0)) return false;
  }
  return true;
}

bool Corners::areHidden(const Blocker& blocker, Vectors vectors) const {
  bool are_hidden = false;
  runInLanes(
      vectors, [&]<class Types>(Types)
                   __attribute__((always_inline)) { are_hidden = areHiddenBy<typename Types::Doubles>(blocker); });
  return are_hidden;
}

uint32_t Corners::findHider(const std::vector<Blocker>& blockers, const BlockerList& list, Vectors vectors) const {
  uint32_t found = UINT32_MAX;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        using Doubles = typename Types::Doubles;
        // A blocker that hides the second end meets the line between the middles of both ends. So boxes that this line
        // misses are passed over.
        const auto isHider = [&](uint32_t index) __attribute__((always_inline)) {
          const bool is_hider = areHiddenBy<Doubles>(blockers[index]);
          if (is_hider) found = index;
          return is_hider;
        };
        forEachOnLine<Doubles>(list, middles_[0], middles_[1], kTouchingShaft, isHider);
      });
  return found;
}

bool areApart(const Patch& patch, const Blocker& blocker) {
  if (patch.plane == blocker.plane) return false;
  // The blocker's plane may separate the two, or a plane through an edge of the patch, orthogonal to the patch. The
  // patch's own plane does not count: a blocker that stands on the patch touches it inside its edges.
  double least = INFINITY, largest = -INFINITY;
  for (const dvec3& corner : patch.corners) {
    const double height = glm::dot(blocker.normal, corner) - blocker.offset;
    least = std::min(least, height), largest = std::max(largest, height);
  }
  if ((least >= -kTouchingShaft && largest > kTouchingShaft) || (largest <= kTouchingShaft && least < -kTouchingShaft))
    return true;
  const auto isBeyond = [&](const dvec3& normal, double offset) {
    for (uint32_t c = 0; c < blocker.corner_count; ++c)
      if (glm::dot(normal, blocker.corners[c]) - offset < -kTouchingShaft) return false;
    return true;
  };
  for (uint32_t e = 0; e < patch.corner_count; ++e)
    if (isBeyond(patch.edge_normals[e], patch.edge_offsets[e])) return true;
  return false;
}

bool areApart(const Box& box, const Blocker& blocker) {
  const dvec3 middle = 0.5 * (box.low + box.high), reach = 0.5 * (box.high - box.low);
  const double height = glm::dot(blocker.normal, middle) - blocker.offset;
  if (std::abs(height) > glm::dot(glm::abs(blocker.normal), reach) + kInPlane) return true;
  const dvec3 gap = glm::max(blocker.low - box.high, box.low - blocker.high);
  return std::max({gap.x, gap.y, gap.z}) > kInPlane;
}

}  // namespace viewpeel
