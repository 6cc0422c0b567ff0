#include "pair_lines/shafts.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace viewpeel {

using glm::dvec3;

void BlockerList::clear() {
  indices.clear();
  for (int axis = 0; axis < 3; ++axis) low[axis].clear(), high[axis].clear();
}

void BlockerList::add(uint32_t index, const Blocker& blocker) {
  indices.push_back(index);
  for (int axis = 0; axis < 3; ++axis) low[axis].push_back(blocker.low[axis]), high[axis].push_back(blocker.high[axis]);
}

void BlockerList::add(const BlockerList& from, size_t k) {
  indices.push_back(from.indices[k]);
  for (int axis = 0; axis < 3; ++axis) low[axis].push_back(from.low[axis][k]), high[axis].push_back(from.high[axis][k]);
}

void BlockerList::pad() {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis].resize((size() + kBlockerLanes - 1) / kBlockerLanes * kBlockerLanes, INFINITY);
    high[axis].resize(low[axis].size(), INFINITY);
  }
}

BoxShaft::BoxShaft(const Box& a, const Box& b) {
  const Box both{glm::min(a.low, b.low), glm::max(a.high, b.high)};
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      dvec3 normal(0);
      normal[axis] = sign;
      planes_[plane_count_++] = {normal, sign > 0 ? both.high[axis] : -both.low[axis]};
    }
  // A plane along one axis touches both boxes where its normal points into the quadrant of the corners that it joins.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double sign_u : {1.0, -1.0})
      for (const double sign_v : {1.0, -1.0}) {
        const auto cornerOf = [&](const Box& box) {
          return glm::dvec2(sign_u > 0 ? box.high[u] : box.low[u], sign_v > 0 ? box.high[v] : box.low[v]);
        };
        const glm::dvec2 from = cornerOf(a), along = cornerOf(b) - from;
        glm::dvec2 normal(along.y, -along.x);
        if (normal.x * sign_u < 0) normal = -normal;
        if (!(normal.x * sign_u > 0) || !(normal.y * sign_v > 0)) continue;
        normal = glm::normalize(normal);
        OutwardPlane& plane = planes_[plane_count_++];
        plane.normal[u] = normal.x, plane.normal[v] = normal.y;
        plane.offset = glm::dot(normal, from);
      }
  }
}

void BoxShaft::keepInside(const BlockerList& from, BlockerList& to, Vectors vectors) const {
  runVectorised(
      vectors, [&]() __attribute__((always_inline)) { keepInsideAll(from, to); });
}

[[gnu::always_inline]] inline void BoxShaft::keepInsideAll(const BlockerList& from, BlockerList& to) const {
  for (size_t first = 0; first < from.size(); first += kBlockerLanes) {
    Doubles outside = all(-double(INFINITY));
    for (int p = 0; p < plane_count_; ++p) {
      const OutwardPlane& plane = planes_[p];
      Doubles nearest = all(kTouchingShaft - plane.offset);
      for (int axis = 0; axis < 3; ++axis) {
        if (plane.normal[axis] == 0) continue;
        const auto& bound = plane.normal[axis] > 0 ? from.low[axis] : from.high[axis];
        nearest += plane.normal[axis] * load<Doubles>(&bound[first]);
      }
      outside = greatest(outside, nearest);
    }
    for (size_t k = 0; k < kBlockerLanes && first + k < from.size(); ++k)
      if (outside[k] < 0) to.add(from, first + k);
  }
}

bool hidesBox(const Blocker& blocker, const Box& a, const Box& b) {
  const auto cornerOf = [](const Box& box, int k) {
    return dvec3(k & 1 ? box.high.x : box.low.x, k & 2 ? box.high.y : box.low.y, k & 4 ? box.high.z : box.low.z);
  };
  // The nearest and the farthest corner along the blocker's normal.
  const auto rangeOf = [&](const Box& box) {
    const dvec3 middle = 0.5 * (box.low + box.high), reach = 0.5 * (box.high - box.low);
    const double at = glm::dot(blocker.normal, middle) - blocker.offset,
                 spread = glm::dot(glm::abs(blocker.normal), reach);
    return glm::dvec2(at - spread, at + spread);
  };
  const glm::dvec2 range_a = rangeOf(a), range_b = rangeOf(b);
  const bool is_between = (range_a.x > kTouchingShaft && range_b.y < -kTouchingShaft) ||
                          (range_a.y < -kTouchingShaft && range_b.x > kTouchingShaft);
  if (!is_between) return false;
  for (int i = 0; i < 8; ++i) {
    const dvec3 p = cornerOf(a, i);
    const double height_p = glm::dot(blocker.normal, p) - blocker.offset;
    for (int j = 0; j < 8; ++j) {
      const dvec3 q = cornerOf(b, j);
      const double height_q = glm::dot(blocker.normal, q) - blocker.offset;
      const dvec3 x = p + height_p / (height_p - height_q) * (q - p);
      for (uint32_t e = 0; e < blocker.corner_count; ++e)
        if (glm::dot(blocker.edge_normals[e], x) - blocker.edge_offsets[e] > 0) return false;
    }
  }
  return true;
}

PatchShaft::PatchShaft(const Patch& a, const Patch& b) : a_(a), b_(b) {
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) corners_[axis][k] = a.corners[k][axis], corners_[axis][4 + k] = b.corners[k][axis];
  addTangents(a, b);
  addTangents(b, a);
  const dvec3 low = glm::min(a.low, b.low), high = glm::max(a.high, b.high);
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 normal(0);
    normal[axis] = 1;
    addPlane(normal, high[axis]);
    addPlane(-normal, -low[axis]);
  }
  while (plane_count_ < 16) addPlane(-a.normal, -a.offset);
}

void PatchShaft::addPlane(const dvec3& normal, double offset) {
  for (int axis = 0; axis < 3; ++axis) planes_[axis][plane_count_] = normal[axis];
  planes_[3][plane_count_++] = -offset;
}

// The plane of a itself, and through each edge of a the plane that has all of b which a can see on its inner side.
void PatchShaft::addTangents(const Patch& a, const Patch& b) {
  addPlane(-a.normal, -a.offset);
  double height[4];
  for (uint32_t k = 0; k < b.corner_count; ++k) height[k] = glm::dot(a.normal, b.corners[k]) - a.offset;
  for (uint32_t e = 0; e < a.corner_count; ++e) {
    double outward[4], slope = -INFINITY;
    for (uint32_t k = 0; k < b.corner_count; ++k) {
      outward[k] = glm::dot(a.edge_normals[e], b.corners[k]) - a.edge_offsets[e];
      if (height[k] > kTouchingShaft) slope = std::max(slope, outward[k] / height[k]);
    }
    // Where b crosses a's plane beyond the edge no plane through the edge has it on its inner side.
    bool is_open = false;
    for (uint32_t k = 0; k < b.corner_count; ++k) {
      if (height[k] <= kTouchingShaft && height[k] >= -kTouchingShaft) is_open |= outward[k] > kTouchingShaft;
      for (uint32_t m = 0; m < b.corner_count; ++m)
        if (height[k] > kTouchingShaft && height[m] < -kTouchingShaft)
          is_open |= outward[m] * height[k] - outward[k] * height[m] > 0;
    }
    if (is_open || !(slope > -INFINITY)) continue;
    const double scale = 1 / std::sqrt(1 + slope * slope);
    addPlane(scale * (a.edge_normals[e] - slope * a.normal), scale * (a.edge_offsets[e] - slope * a.offset));
  }
}

[[gnu::always_inline]] inline bool PatchShaft::isOutside(const Blocker& blocker) const {
  const double *x = planes_[0], *y = planes_[1], *z = planes_[2], *w = planes_[3];
  Doubles nearest[2] = {all(double(INFINITY)), all(double(INFINITY))};
  for (uint32_t c = 0; c < blocker.corner_count; ++c)
    for (int half = 0; half < 2; ++half) {
      const int at = half * kBlockerLanes;
      const glm::dvec3& corner = blocker.corners[c];
      const Doubles beyond = load<Doubles>(x + at) * corner.x + load<Doubles>(y + at) * corner.y +
                             load<Doubles>(z + at) * corner.z + load<Doubles>(w + at);
      nearest[half] = least(nearest[half], beyond);
    }
  return largestOf(greatest(nearest[0], nearest[1])) >= -kTouchingShaft;
}

//   In: heights of the eight corners over the blocker's plane
[[gnu::always_inline]] inline bool PatchShaft::hides(const Blocker& blocker, const Doubles& heights) const {
  int above_a = 0, above_b = 0, below_a = 0, below_b = 0;
  for (int k = 0; k < 4; ++k) {
    above_a += heights[k] > kTouchingShaft, below_a += heights[k] < -kTouchingShaft;
    above_b += heights[4 + k] > kTouchingShaft, below_b += heights[4 + k] < -kTouchingShaft;
  }
  const bool is_between = (above_a && !below_a && below_b && !above_b) || (below_a && !above_a && above_b && !below_b);
  if (!is_between) return false;
  for (int i = 0; i < 4; ++i) {
    const double p[3] = {corners_[0][i], corners_[1][i], corners_[2][i]}, height = heights[i];
    // The lines to b's corners, twice.
    const Doubles difference = height - heights;
    for (int j = 4; j < 8; ++j)
      if (!(difference[j] != 0)) return false;
    const Doubles t = height / difference;
    Doubles beyond = all(-double(INFINITY));
    for (uint32_t e = 0; e < blocker.corner_count; ++e) {
      const dvec3& m = blocker.edge_normals[e];
      const Doubles at = m.x * (p[0] + t * (corners_[0] - p[0])) + m.y * (p[1] + t * (corners_[1] - p[1])) +
                         m.z * (p[2] + t * (corners_[2] - p[2])) - blocker.edge_offsets[e];
      beyond = greatest(beyond, at);
    }
    for (int j = 4; j < 8; ++j)
      if (!(beyond[j] <= kTouchingShaft)) return false;
  }
  return true;
}

bool PatchShaft::isHidden(const std::vector<Blocker>& blockers, std::span<const uint32_t> from,
                          std::vector<uint32_t>& between, Vectors vectors) const {
  bool is_hidden = false;
  runVectorised(
      vectors, [&]() __attribute__((always_inline)) { is_hidden = isHiddenByOne(blockers, from, between); });
  return is_hidden;
}

[[gnu::always_inline]] inline bool PatchShaft::isHiddenByOne(const std::vector<Blocker>& blockers,
                                                             std::span<const uint32_t> from,
                                                             std::vector<uint32_t>& between) const {
  for (const uint32_t index : from) {
    const Blocker& blocker = blockers[index];
    if (blocker.plane == a_.plane || blocker.plane == b_.plane) continue;
    const Doubles heights = corners_[0] * blocker.normal.x + corners_[1] * blocker.normal.y +
                            corners_[2] * blocker.normal.z - blocker.offset;
    if (largestOf(heights) <= kTouchingShaft || leastOf(heights) >= -kTouchingShaft) continue;
    if (isOutside(blocker)) continue;
    between.push_back(index);
    if (hides(blocker, heights)) return true;
  }
  return false;
}

}  // namespace viewpeel
