#include "rays/ray_tree.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <glm/glm.hpp>

#include "scene/coincident.h"
#include "scene/perimeter.h"

namespace viewpeel {
namespace {

using glm::dvec3;

constexpr size_t kMostFacets = 4;  // of a leaf
constexpr double kStepCost = 1;    // of a box, in tests of a facet
constexpr int kMostLevels = 200;   // of cuts by the heuristic; below it cuts are in the middle

struct Box {
  dvec3 low{INFINITY}, high{-INFINITY};

  void add(const Box& other) { low = glm::min(low, other.low), high = glm::max(high, other.high); }
  double halfArea() const {
    const dvec3 size = high - low;
    return size.x * size.y + size.y * size.z + size.z * size.x;
  }
};

}  // namespace

float reachOf(const Scene& scene, const Polygon& polygon) {
  return std::min(kRayReach, static_cast<float>(kReachOfWidth * 2 * polygon.area / perimeterOf(scene, polygon)));
}

RayTree::Facet RayTree::facetOf(const Scene& scene, uint32_t index) {
  const Polygon& polygon = scene.polygons[index];
  const Plane& plane = scene.planes[polygon.plane];
  const dvec3* const corners = &scene.corners[polygon.first_corner];
  const dvec3 front = frontNormal(scene, polygon);
  RayTree::Facet facet{};
  const auto set = [&](int k, const dvec3& normal, double offset, float* rounded) {
    for (int axis = 0; axis < 3; ++axis)
      facet.planes[axis][k] = normal[axis], rounded[axis] = static_cast<float>(normal[axis]);
    facet.planes[3][k] = -offset;
  };
  set(0, plane.normal, plane.offset, facet.normal);
  for (uint32_t e = 0; e < 4; ++e) {
    const uint32_t from = e < polygon.corner_count ? e : 0, to = (from + 1) % polygon.corner_count;
    const dvec3 outward = glm::normalize(glm::cross(corners[to] - corners[from], front));
    set(static_cast<int>(e) + 1, outward, glm::dot(outward, corners[from]), facet.edges[e]);
  }
  facet.reach = reachOf(scene, polygon);
  facet.side = polygon.front_along_plane_normal ? 1.0f : -1.0f;
  facet.level = static_cast<float>(levelOf(polygon));
  facet.polygon = index, facet.plane = polygon.plane;
  return facet;
}

struct RayTree::Item {
  Box box;
  uint32_t polygon;
  double at(int axis) const { return box.low[axis] + box.high[axis]; }
};

RayTree::RayTree(const Scene& scene, bool two_sided) : reach_of_backs_(two_sided ? 1.0f : -1.0f) {
  std::vector<Item> items(scene.polygons.size());
  for (uint32_t k = 0; k < items.size(); ++k) {
    items[k].polygon = k;
    const Polygon& polygon = scene.polygons[k];
    for (uint32_t c = 0; c < polygon.corner_count; ++c) {
      const dvec3& corner = scene.corners[polygon.first_corner + c];
      items[k].box.add({corner, corner});
    }
  }
  facets_.reserve(items.size());
  build(scene, items);
}

void RayTree::build(const Scene& scene, std::vector<Item>& items) {
  // A Range of the items waits to become node `node`, `level` cuts below the root.
  struct Range {
    size_t first, end, node;
    int level;
  };
  nodes_.emplace_back();
  std::vector<Range> waiting{{0, items.size(), 0, 0}};
  std::vector<double> above;  // cost of the items from each one on
  while (!waiting.empty()) {
    const Range range = waiting.back();
    waiting.pop_back();
    const auto of_range = std::span(items).subspan(range.first, range.end - range.first);
    const size_t count = of_range.size();
    Box box;
    for (const Item& item : of_range) box.add(item.box);
    for (int axis = 0; axis < 3; ++axis) {
      nodes_[range.node].low[axis] = static_cast<float>(box.low[axis]) - kRayReach;
      nodes_[range.node].high[axis] = static_cast<float>(box.high[axis]) + kRayReach;
    }
    const auto sortAlong = [&](int axis) {
      std::ranges::sort(of_range, {}, [&](const Item& item) { return std::pair(item.at(axis), item.polygon); });
    };
    double least_cost = INFINITY;
    size_t cut = count / 2;
    int cut_axis = 0;
    above.resize(count + 1);
    for (int axis = 0; axis < 3 && count > 1; ++axis) {
      sortAlong(axis);
      Box part;
      for (size_t k = count; k-- > 1;) {
        part.add(of_range[k].box);
        above[k] = part.halfArea() * double(count - k);
      }
      part = {};
      for (size_t k = 1; k < count; ++k) {
        part.add(of_range[k - 1].box);
        const double cost = part.halfArea() * double(k) + above[k];
        if (cost < least_cost) least_cost = cost, cut_axis = axis, cut = k;
      }
    }
    if (range.level >= kMostLevels) cut = count / 2;
    Node& node = nodes_[range.node];
    if (count <= kMostFacets && least_cost + kStepCost * box.halfArea() >= double(count) * box.halfArea()) {
      node.first = static_cast<uint32_t>(facets_.size()), node.facets = static_cast<uint32_t>(count);
      for (const Item& item : of_range) facets_.push_back(facetOf(scene, item.polygon));
      continue;
    }
    sortAlong(cut_axis);
    const size_t child = nodes_.size();
    node.first = static_cast<uint32_t>(child), node.axis = cut_axis;
    nodes_.resize(child + 2);
    waiting.push_back({range.first + cut, range.end, child + 1, range.level + 1});
    waiting.push_back({range.first, range.first + cut, child, range.level + 1});
  }
}

}  // namespace viewpeel
