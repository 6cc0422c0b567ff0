#include "pair_lines/shafts.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/glm.hpp>

namespace viewpeel {

using glm::dvec3;

namespace {

Box boxOf(const Patch& patch) { return {patch.low, patch.high}; }

constexpr double kInfinity = INFINITY;

constexpr uint32_t kLanesOfA = 0x0F, kLanesOfB = 0xF0;

// Sides say which corners of two patches lie above and below a blocker's plane: bits 0 to 3 are corners of a, 4 to 7
// corners of b.
struct Sides {
  uint32_t above, below;
  // Returns whether a lies on one side of the plane and b on the other.
  bool areBetween() const { return sideOf(kLanesOfA) * sideOf(kLanesOfB) < 0; }
  // Returns 1 where these corners lie above the plane, -1 where below, and 0 where on both sides of it or within it.
  int sideOf(uint32_t lanes) const { return int((above & lanes) != 0) - int((below & lanes) != 0); }
};

template <class Doubles>
VIEWPEEL_INLINE Sides sidesOf(const Doubles& heights) {
  return {bitsAtMost<Doubles>(-heights, -kTouchingShaft), bitsAtMost<Doubles>(heights, -kTouchingShaft)};
}

// A Tangent is a plane through an edge of a patch. The patch lies on its inner side, and so do all points of the other
// end that are in front of the patch.
struct Tangent {
  bool is_found = false;
  dvec3 normal{0};
  double offset = 0;
};

// Returns the tangent through an edge of a.    In: heights: of the other end's corners over a's plane
Tangent tangentOf(const Patch& a, uint32_t edge, std::span<const dvec3> corners, std::span<const double> heights) {
  double outward[8], slope = -INFINITY;
  for (size_t k = 0; k < corners.size(); ++k) {
    outward[k] = glm::dot(a.edge_normals[edge], corners[k]) - a.edge_offsets[edge];
    if (heights[k] > kTouchingShaft) slope = std::max(slope, outward[k] / heights[k]);
  }
  if (!(slope > -INFINITY)) return {};
  // Where the other end crosses the plane of patch a beyond the edge, there is no tangent.
  for (size_t k = 0; k < corners.size(); ++k) {
    if (heights[k] > kTouchingShaft) continue;
    if (heights[k] >= -kTouchingShaft) {
      if (outward[k] > kTouchingShaft) return {};
      continue;
    }
    for (size_t m = 0; m < corners.size(); ++m)
      if (heights[m] > kTouchingShaft && outward[k] * heights[m] - outward[m] * heights[k] > 0) return {};
  }
  const double scale = 1 / std::sqrt(1 + slope * slope);
  return {true, scale * (a.edge_normals[edge] - slope * a.normal), scale * (a.edge_offsets[edge] - slope * a.offset)};
}

}  // namespace

Shaft::Shaft(const Box& a, const Box& b) : both_{glm::min(a.low, b.low), glm::max(a.high, b.high)} {
  // The boxes are projected along each axis. A line through a corner of each is an edge of their hull where its normal
  // points into the quadrant in which both corners are extreme.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double sign_u : {1.0, -1.0})
      for (const double sign_v : {1.0, -1.0}) {
        const auto cornerAt = [&](const Box& box) {
          return glm::dvec2(sign_u > 0 ? box.high[u] : box.low[u], sign_v > 0 ? box.high[v] : box.low[v]);
        };
        const glm::dvec2 from = cornerAt(a), along = cornerAt(b) - from;
        glm::dvec2 across(along.y, -along.x);
        if (across.x * sign_u < 0) across = -across;
        if (!(across.x * sign_u > 0) || !(across.y * sign_v > 0)) continue;
        across = glm::normalize(across);
        dvec3 normal(0);
        normal[u] = across.x, normal[v] = across.y;
        addPlane(normal, glm::dot(across, from));
      }
  }
}

Shaft::Shaft(const Patch& a, const Box& b) : Shaft(boxOf(a), b) {
  addPlane(-a.normal, -a.offset);
  dvec3 corners[8];
  double heights[8];
  for (int k = 0; k < 8; ++k) {
    corners[k] = cornerOf(b, k);
    heights[k] = glm::dot(a.normal, corners[k]) - a.offset;
  }
  for (uint32_t e = 0; e < a.corner_count; ++e)
    if (const Tangent tangent = tangentOf(a, e, corners, heights); tangent.is_found)
      addPlane(tangent.normal, tangent.offset);
}

void Shaft::addPlane(const dvec3& normal, double offset) {
  OutwardPlane& plane = planes_[plane_count_++];
  plane.offset = offset;
  for (int axis = 0; axis < 3; ++axis) {
    plane.normal[axis] = normal[axis];
    plane.bounds[axis] = normal[axis] > 0 ? axis : 3 + axis;
  }
}

void Shaft::keepInside(const BlockerList& from, BlockerList& to, Vectors vectors) const {
  to.clear(from.size());
  runInLanes(
      vectors, [&]<class Types>(Types)
                   __attribute__((always_inline)) { keepInsideAll<typename Types::Doubles>(from, to); });
  to.close();
}

bool Shaft::isOutside(const std::array<dvec3, 2>& edge) const {
  const dvec3 low = glm::min(edge[0], edge[1]), high = glm::max(edge[0], edge[1]);
  for (int axis = 0; axis < 3; ++axis)
    if (low[axis] - both_.high[axis] >= -kTouchingShaft || both_.low[axis] - high[axis] >= -kTouchingShaft) return true;
  for (int p = 0; p < plane_count_; ++p) {
    const OutwardPlane& plane = planes_[p];
    const dvec3 normal(plane.normal[0], plane.normal[1], plane.normal[2]);
    if (std::min(glm::dot(normal, edge[0]), glm::dot(normal, edge[1])) - plane.offset >= -kTouchingShaft) return true;
  }
  return false;
}

template <class Doubles>
[[gnu::always_inline]] inline void Shaft::keepInsideAll(const BlockerList& from, BlockerList& to) const {
  for (size_t g = 0; g < from.groupCount(); ++g) {
    const BlockerList::Group& group = from.group(g);
    // Each lane is one blocker's box: the distance of its nearest point from the shaft, below 0 inside.
    Doubles outside = -kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      outside = greatest(outside, load<Doubles>(group.bounds[axis]) - both_.high[axis]);
      outside = greatest(outside, both_.low[axis] - load<Doubles>(group.bounds[3 + axis]));
    }
    for (int p = 0; p < plane_count_; ++p) {
      const OutwardPlane& plane = planes_[p];
      const Doubles nearest = plane.normal[0] * load<Doubles>(group.bounds[plane.bounds[0]]) +
                              plane.normal[1] * load<Doubles>(group.bounds[plane.bounds[1]]) +
                              plane.normal[2] * load<Doubles>(group.bounds[plane.bounds[2]]) - plane.offset;
      outside = greatest(outside, nearest);
    }
    for (uint32_t inside = bitsAtMost<Doubles>(outside, -kTouchingShaft); inside; inside &= inside - 1)
      to.add(group, std::countr_zero(inside));
  }
}

PatchShaft::PatchShaft(const Patch& a, const Patch& b) : a_(a), b_(b) {
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) corners_[axis][k] = a.corners[k][axis], corners_[axis][4 + k] = b.corners[k][axis];
}

void PatchShaft::findPlanes() {
  const auto addTangents = [&](const Patch& a, const Patch& b) {
    addPlane(-a.normal, -a.offset);
    double heights[4];
    for (uint32_t k = 0; k < b.corner_count; ++k) heights[k] = glm::dot(a.normal, b.corners[k]) - a.offset;
    for (uint32_t e = 0; e < a.corner_count; ++e) {
      const Tangent tangent = tangentOf(a, e, std::span(b.corners, b.corner_count), std::span(heights, b.corner_count));
      if (tangent.is_found) addPlane(tangent.normal, tangent.offset);
    }
  };
  addTangents(a_, b_);
  addTangents(b_, a_);
  const dvec3 low = glm::min(a_.low, b_.low), high = glm::max(a_.high, b_.high);
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 normal(0);
    normal[axis] = 1;
    addPlane(normal, high[axis]);
    addPlane(-normal, -low[axis]);
  }
  used_planes_ = plane_count_;
  while (plane_count_ < 16) addPlane(-a_.normal, -a_.offset);
}

void PatchShaft::addPlane(const dvec3& normal, double offset) {
  for (int axis = 0; axis < 3; ++axis) planes_[axis][plane_count_] = normal[axis];
  planes_[3][plane_count_++] = -offset;
}

template <class Doubles>
[[gnu::always_inline]] inline bool PatchShaft::isOutside(const Blocker& blocker) const {
  const double *x = planes_[0], *y = planes_[1], *z = planes_[2], *w = planes_[3];
  Doubles nearest[2] = {kInfinity, kInfinity};
  for (uint32_t c = 0; c < blocker.corner_count; ++c)
    for (int half = 0; half < 2; ++half) {
      const int at = half * kBlockerLanes;
      const glm::dvec3& corner = blocker.corners[c];
      const Doubles beyond = load<Doubles>(x + at) * corner.x + load<Doubles>(y + at) * corner.y +
                             load<Doubles>(z + at) * corner.z + load<Doubles>(w + at);
      nearest[half] = least(nearest[half], beyond);
    }
  return !areAllAtMost<Doubles>(greatest(nearest[0], nearest[1]), -kTouchingShaft);
}

template <class Doubles>
[[gnu::always_inline]] inline Doubles PatchShaft::heightsOver(const Blocker& blocker) const {
  Doubles corners[3];
  for (int axis = 0; axis < 3; ++axis) corners[axis] = load<Doubles>(corners_[axis]);
  return heightsOverPlane(corners, blocker);
}

// Returns whether the blocker, whose plane lies between a and b, hides all of b from a.
//   In: heights: of the eight corners over the blocker's plane, four of a and four of b
template <class Doubles>
[[gnu::always_inline]] inline bool PatchShaft::hides(const Blocker& blocker, const Doubles& heights) const {
  Doubles corners[3];
  for (int axis = 0; axis < 3; ++axis) corners[axis] = load<Doubles>(corners_[axis]);
  for (int i = 0; i < 4; ++i) {
    const double p[3] = {corners_[0][i], corners_[1][i], corners_[2][i]}, height = heights[i];
    // Lanes 4 to 7 are the lines to b's corners.
    const Doubles difference = height - heights;
    for (int j = 4; j < 8; ++j)
      if (!(difference[j] != 0)) return false;
    const Doubles t = height / difference;
    Doubles beyond = -kInfinity;
    for (uint32_t e = 0; e < blocker.corner_count; ++e) {
      const dvec3& m = blocker.edge_normals[e];
      const Doubles at = m.x * (p[0] + t * (corners[0] - p[0])) + m.y * (p[1] + t * (corners[1] - p[1])) +
                         m.z * (p[2] + t * (corners[2] - p[2])) - blocker.edge_offsets[e];
      beyond = greatest(beyond, at);
    }
    if ((bitsAtMost<Doubles>(beyond, kTouchingShaft) & kLanesOfB) != kLanesOfB) return false;
  }
  return true;
}

bool PatchShaft::isHiddenBy(const Blocker& blocker, Vectors vectors) const {
  if (blocker.plane == a_.plane || blocker.plane == b_.plane) return false;
  bool is_hidden = false;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        const auto heights = heightsOver<typename Types::Doubles>(blocker);
        is_hidden = sidesOf(heights).areBetween() && hides(blocker, heights);
      });
  return is_hidden;
}

bool PatchShaft::isHidden(const std::vector<Blocker>& blockers, const BlockerList& from, std::vector<uint32_t>& between,
                          Vectors vectors) {
  if (from.size() == 0) return false;
  findPlanes();
  bool is_hidden = false;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        is_hidden = isHiddenByOne<typename Types::Doubles>(blockers, from, between);
      });
  return is_hidden;
}

template <class Doubles>
[[gnu::always_inline]] inline bool PatchShaft::isHiddenByOne(const std::vector<Blocker>& blockers,
                                                             const BlockerList& from,
                                                             std::vector<uint32_t>& between) const {
  int bounds[3][16];
  for (int p = 0; p < used_planes_; ++p)
    for (int axis = 0; axis < 3; ++axis) bounds[axis][p] = planes_[axis][p] > 0 ? axis : 3 + axis;
  for (size_t g = 0; g < from.groupCount(); ++g) {
    const BlockerList::Group& group = from.group(g);
    // Eight boxes at once are tested against the shaft first, then the corners of blockers whose boxes reach into it.
    // Each lane is the distance of a box's nearest point from the shaft, below 0 inside.
    Doubles outside = -kInfinity;
    for (int p = 0; p < used_planes_; ++p)
      outside = greatest(outside, planes_[0][p] * load<Doubles>(group.bounds[bounds[0][p]]) +
                                      planes_[1][p] * load<Doubles>(group.bounds[bounds[1][p]]) +
                                      planes_[2][p] * load<Doubles>(group.bounds[bounds[2][p]]) + planes_[3][p]);
    for (uint32_t inside = bitsAtMost<Doubles>(outside, -kTouchingShaft); inside; inside &= inside - 1) {
      const uint32_t index = group.indices[std::countr_zero(inside)];
      const Blocker& blocker = blockers[index];
      if (blocker.plane == a_.plane || blocker.plane == b_.plane) continue;
      const Doubles heights = heightsOver<Doubles>(blocker);
      const Sides sides = sidesOf(heights);
      if (!sides.above || !sides.below || isOutside<Doubles>(blocker)) continue;
      between.push_back(index);
      if (sides.areBetween() && hides(blocker, heights)) return true;
    }
  }
  return false;
}

bool PatchShaft::isOutside(const std::array<dvec3, 2>& ends) const {
  for (int p = 0; p < used_planes_; ++p) {
    const dvec3 normal(planes_[0][p], planes_[1][p], planes_[2][p]);
    if (std::min(glm::dot(normal, ends[0]), glm::dot(normal, ends[1])) + planes_[3][p] >= -kTouchingShaft) return true;
  }
  return false;
}

bool PatchShaft::areLinesBlocked(const std::vector<Blocker>& blockers, std::span<const uint32_t> between,
                                 Vectors vectors) const {
  // Eight lines between points near the corners of a and b: four to the corner of the same index, four crosswise.
  alignas(64) double starts[3][8], ends[3][8];
  constexpr double kToMiddle = 0.05;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 8; ++k) {
      const int of_b = k < 4 ? k : (k + 2) % 4;
      starts[axis][k] = glm::mix(a_.corners[k % 4][axis], a_.middle[axis], kToMiddle);
      ends[axis][k] = glm::mix(b_.corners[of_b][axis], b_.middle[axis], kToMiddle);
    }
  bool are_blocked = false;
  runInLanes(
      vectors, [&]<class Types>(Types) __attribute__((always_inline)) {
        using Doubles = typename Types::Doubles;
        Doubles p[3], q[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = load<Doubles>(starts[axis]), q[axis] = load<Doubles>(ends[axis]);
        uint32_t free = Doubles::kAllBits;  // lines on which no blocker lies so far
        for (const uint32_t index : between) {
          const Blocker& blocker = blockers[index];
          const Doubles from = heightsOverPlane(p, blocker), to = heightsOverPlane(q, blocker), t = from / (from - to);
          const Doubles x = p[0] + t * (q[0] - p[0]), y = p[1] + t * (q[1] - p[1]), z = p[2] + t * (q[2] - p[2]);
          Doubles beyond = from * to;
          for (uint32_t e = 0; e < blocker.corner_count; ++e) {
            const dvec3& m = blocker.edge_normals[e];
            beyond = greatest(beyond, m.x * x + m.y * y + m.z * z - blocker.edge_offsets[e]);
          }
          free &= ~bitsAtMost<Doubles>(beyond, kTouchingShaft);
          if (free == 0) break;
        }
        are_blocked = free == 0;
      });
  return are_blocked;
}

}  // namespace viewpeel
