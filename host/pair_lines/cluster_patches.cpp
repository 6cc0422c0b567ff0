// This file makes clusters of patches, and finds which blockers of a patch's plane cover it.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include <glm/glm.hpp>

#include "pair_lines/find_pairs.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr uint32_t kLeafPatches = 16;
// Clusters gather patches that are close in place and in normal. A difference of normals counts as this many sizes of
// patches: with fewer, flat clusters, which do not face each other, are broken up (a refined office takes 8 % longer at
// 1); with more, clusters of a large city stretch over it, and much lies between them (a surveyed city of 36,257
// triangles takes 2.4 times as long with clusters that spread over 0.3 of its radius).
constexpr double kNormalSizes = 5;

// Returns the median of the square roots of the patches' areas.
double medianSize(const std::vector<Patch>& patches) {
  std::vector<double> areas;
  for (const Patch& patch : patches) areas.push_back(patch.area);
  const auto middle = areas.begin() + static_cast<ptrdiff_t>(areas.size() / 2);
  std::ranges::nth_element(areas, middle);
  return std::sqrt(*middle);
}

// Returns whether convex polygons of one plane have more than an edge in common.
template <class A, class B>
bool overlap(const A& a, uint32_t corners_a, const B& b, uint32_t corners_b) {
  const auto isApart = [](const auto& p, uint32_t edges, const auto& q, uint32_t corners) {
    for (uint32_t e = 0; e < edges; ++e) {
      double nearest = INFINITY;
      for (uint32_t c = 0; c < corners; ++c)
        nearest = std::min(nearest, glm::dot(p.edge_normals[e], q.corners[c]) - p.edge_offsets[e]);
      if (nearest >= -kTouchingShaft) return true;
    }
    return false;
  };
  return !isApart(a, corners_a, b, corners_b) && !isApart(b, corners_b, a, corners_a);
}

}  // namespace

bool overlaps(const Blocker& blocker, const Patch& patch) {
  return overlap(blocker, blocker.corner_count, patch, patch.corner_count);
}

bool covers(const Blocker& blocker, const Patch& patch) {
  for (uint32_t e = 0; e < blocker.corner_count; ++e)
    for (uint32_t c = 0; c < patch.corner_count; ++c)
      if (glm::dot(blocker.edge_normals[e], patch.corners[c]) - blocker.edge_offsets[e] > kTouchingShaft) return false;
  return true;
}

PairFinder::PairFinder(const Scene& scene, const Ids& ids, const LeakingFaces& leaking, bool ends_on_blockers)
    : two_sided_(ids.two_sided), patches_(makePatches(scene, ids, leaking, ends_on_blockers)), unoccluded_(scene) {
  std::vector<uint32_t> of_polygon;
  blockers_ = makeBlockers(scene, true, &of_polygon);
  mesh_ = std::make_unique<BlockerMesh>(scene, of_polygon, blockers_.size());
  // Large blockers come first, for they hide most: where one covers the whole patch, smaller ones need no test.
  std::vector<double> sizes;
  for (const Blocker& blocker : blockers_) {
    glm::dvec3 area(0);
    for (uint32_t c = 2; c < blocker.corner_count; ++c)
      area += glm::cross(blocker.corners[c - 1] - blocker.corners[0], blocker.corners[c] - blocker.corners[0]);
    sizes.push_back(glm::length(area));
  }
  largest_first_.resize(blockers_.size());
  std::iota(largest_first_.begin(), largest_first_.end(), 0u);
  std::ranges::stable_sort(largest_first_, std::ranges::greater{}, [&](uint32_t k) { return sizes[k]; });
  findCovers();
  order_.resize(patches_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  if (patches_.empty()) return;
  measureRows(ids);
  normal_weight_ = kNormalSizes * medianSize(patches_);
  build(order_, 0, static_cast<uint32_t>(patches_.size()));
}

// Makes an extent that holds another one, too.
void PairFinder::widen(Extent& extent, const Extent& by) const {
  extent.box.low = glm::min(extent.box.low, by.box.low), extent.box.high = glm::max(extent.box.high, by.box.high);
  extent.largest_area = std::max(extent.largest_area, by.largest_area);
  if (extent.patch == UINT32_MAX) extent.patch = by.patch;
  const Patch &one = patches_[extent.patch], &other = patches_[by.patch];
  extent.is_flat &=
      by.is_flat && other.plane == one.plane && (two_sided_ || other.along_plane_normal == one.along_plane_normal);
}

// Sets rows_.
void PairFinder::measureRows(const Ids& ids) {
  rows_.resize(2 * size_t{ids.count()});  // backs on which leaking lines end have ids of their own
  std::vector<double> areas(rows_.size());
  for (uint32_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    areas[patch.id] += patch.area / ids.sides();
    widen(rows_[patch.id], {.box = {patch.low, patch.high}, .patch = p});
  }
  for (size_t row = 0; row < rows_.size(); ++row) rows_[row].largest_area = areas[row];
}

void PairFinder::findCovers() {
  covers_.resize(patches_.size());
  is_covered_.resize(patches_.size(), false);
  std::unordered_map<uint32_t, std::vector<uint32_t>> of_plane;
  for (uint32_t k = 0; k < blockers_.size(); ++k) of_plane[blockers_[k].plane].push_back(k);
  for (auto& entry : of_plane) {
    std::vector<uint32_t>& list = entry.second;
    for (size_t k = 0; k < list.size() && !has_unordered_; ++k)
      for (size_t m = 0; m < k && !has_unordered_; ++m) {
        const Blocker &a = blockers_[list[k]], &b = blockers_[list[m]];
        const bool are_apart = glm::any(glm::greaterThan(a.low, b.high)) || glm::any(glm::greaterThan(b.low, a.high));
        has_unordered_ = a.level == b.level && !are_apart && overlap(a, a.corner_count, b, b.corner_count);
      }
    const bool has_levels =
        std::ranges::any_of(list, [&](uint32_t k) { return blockers_[k].level != blockers_[list[0]].level; });
    if (!has_levels) list.clear();
  }
  for (uint32_t p = 0; p < patches_.size(); ++p)
    for (const uint32_t k : of_plane[patches_[p].plane]) {
      if (stepsInFront(blockers_[k], patches_[p]) <= 0) continue;
      if (!overlaps(blockers_[k], patches_[p])) continue;
      covers_[p].push_back(k);
      if (covers(blockers_[k], patches_[p])) is_covered_[p] = true;
    }
}

uint32_t PairFinder::build(std::vector<uint32_t>& order, uint32_t first, uint32_t end) {
  const auto index = static_cast<uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  node.first = first, node.end = end;
  node.box = {dvec3(INFINITY), dvec3(-INFINITY)};
  node.patch = order[first];
  node.is_flat = true;
  double low[6], high[6];
  std::fill_n(low, 6, INFINITY), std::fill_n(high, 6, -INFINITY);
  const auto placeOf = [&](uint32_t p, int axis) {
    return axis < 3 ? patches_[p].middle[axis] : normal_weight_ * patches_[p].normal[axis - 3];
  };
  for (uint32_t k = first; k < end; ++k) {
    const Patch &patch = patches_[order[k]], &one = patches_[node.patch];
    node.box.low = glm::min(node.box.low, patch.low), node.box.high = glm::max(node.box.high, patch.high);
    node.roles |= patch.roles;
    widen(node.rows, rows_[patch.id]);
    node.is_flat &= patch.plane == one.plane && patch.along_plane_normal == one.along_plane_normal;
    for (int axis = 0; axis < 6; ++axis) {
      low[axis] = std::min(low[axis], placeOf(order[k], axis));
      high[axis] = std::max(high[axis], placeOf(order[k], axis));
    }
  }
  if (node.size() > kLeafPatches) {
    int axis = 0;
    for (int other = 1; other < 6; ++other)
      if (high[other] - low[other] > high[axis] - low[axis]) axis = other;
    const uint32_t middle = first + node.size() / 2;
    std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + end, [&](uint32_t p, uint32_t q) {
      const double x = placeOf(p, axis), y = placeOf(q, axis);
      return x != y ? x < y : p < q;
    });
    node.left = build(order, first, middle);
    node.right = build(order, middle, end);
  }
  nodes_[index] = node;
  return index;
}

}  // namespace viewpeel
