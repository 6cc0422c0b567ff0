#include "scene/ccx_elements.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace viewpeel {
namespace {

using Nodes = std::vector<uint32_t>;
using Edge =
    std::pair<uint32_t, uint32_t>;  // two corners, the smaller first; the mid nodes follow the corners in order

const std::vector<Nodes> kBrick = {{4, 3, 2, 1}, {5, 6, 7, 8}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 4, 8, 7}, {4, 1, 5, 8}};
const std::vector<Nodes> kTetrahedron = {{1, 3, 2}, {1, 2, 4}, {2, 3, 4}, {1, 4, 3}};
const std::vector<Nodes> kWedge = {{1, 3, 2}, {4, 5, 6}, {1, 2, 5, 4}, {2, 3, 6, 5}, {4, 6, 3, 1}};
const std::vector<Edge> kBrickEdges = {{1, 2}, {2, 3}, {3, 4}, {1, 4}, {5, 6}, {6, 7},
                                       {7, 8}, {5, 8}, {1, 5}, {2, 6}, {3, 7}, {4, 8}};
const std::vector<Edge> kTetrahedronEdges = {{1, 2}, {2, 3}, {1, 3}, {1, 4}, {2, 4}, {3, 4}};
const std::vector<Edge> kWedgeEdges = {{1, 2}, {2, 3}, {1, 3}, {4, 5}, {5, 6}, {4, 6}, {1, 4}, {2, 5}, {3, 6}};

}  // namespace

uint32_t ccxNodeCount(const std::string& type) {
  const size_t start = type.starts_with("D") ? 1 : 0;
  if (type.compare(start, 3, "C3D") != 0) return 0;
  uint32_t count = 0;
  std::from_chars(type.data() + start + 3, type.data() + type.size(), count);
  constexpr std::array kCounts = {4u, 6u, 8u, 10u, 15u, 20u};
  return std::ranges::find(kCounts, count) != kCounts.end() ? count : 0;
}

std::vector<uint32_t> ccxFaceNodes(uint32_t node_count, uint32_t face) {
  const bool is_brick = node_count == 8 || node_count == 20, is_wedge = node_count == 6 || node_count == 15;
  const std::vector<Nodes>& faces = is_brick ? kBrick : is_wedge ? kWedge : kTetrahedron;
  const std::vector<Edge>& edges = is_brick ? kBrickEdges : is_wedge ? kWedgeEdges : kTetrahedronEdges;
  if (face < 1 || face > faces.size()) return {};
  const Nodes& corners = faces[face - 1];
  const uint32_t corner_count = is_brick ? 8 : is_wedge ? 6 : 4;
  std::vector<uint32_t> nodes;
  for (size_t k = 0; k < corners.size(); ++k) {
    const uint32_t a = corners[k], b = corners[(k + 1) % corners.size()];
    nodes.push_back(a - 1);
    if (node_count == corner_count) continue;
    const auto edge = std::ranges::find(edges, Edge(std::min(a, b), std::max(a, b)));
    nodes.push_back(corner_count + static_cast<uint32_t>(edge - edges.begin()));
  }
  return nodes;
}

}  // namespace viewpeel
