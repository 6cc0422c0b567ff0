#include "pair_lines/blocker_mesh.h"

#include <algorithm>
#include <tuple>

namespace viewpeel {

BlockerMesh::BlockerMesh(const Scene& scene, std::span<const uint32_t> of_polygon, size_t blocker_count) {
  struct Use {
    std::array<double, 6> ends;  // the lower point first
    uint32_t blocker;
    bool operator<(const Use& other) const { return std::tie(ends, blocker) < std::tie(other.ends, other.blocker); }
  };
  std::vector<Use> uses;
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    const auto cornerOf = [&](uint32_t c) {
      const glm::dvec3& p = scene.corners[polygon.first_corner + c % polygon.corner_count];
      return std::array{p.x + 0.0, p.y + 0.0, p.z + 0.0};
    };
    for (uint32_t c = 0; c < polygon.corner_count; ++c) {
      std::array<double, 3> a = cornerOf(c), b = cornerOf(c + 1);
      if (b < a) std::swap(a, b);
      uses.push_back({{a[0], a[1], a[2], b[0], b[1], b[2]}, of_polygon[k]});
    }
  }
  std::ranges::sort(uses, [](const Use& x, const Use& y) { return x < y; });
  std::vector<std::vector<uint32_t>> of_blocker(blocker_count);
  for (size_t first = 0, end; first < uses.size(); first = end) {
    const auto edge = static_cast<uint32_t>(ends_.size());
    const std::array<double, 6>& p = uses[first].ends;
    ends_.push_back({glm::dvec3(p[0], p[1], p[2]), glm::dvec3(p[3], p[4], p[5])});
    first_users_.push_back(static_cast<uint32_t>(users_.size()));
    for (end = first; end < uses.size() && uses[end].ends == p;) {
      const uint32_t blocker = uses[end].blocker;
      size_t times = 0;
      for (; end < uses.size() && uses[end].ends == p && uses[end].blocker == blocker; ++end) ++times;
      if (times % 2 == 0) continue;  // inside the blocker
      users_.push_back(blocker);
      of_blocker[blocker].push_back(edge);
    }
  }
  first_users_.push_back(static_cast<uint32_t>(users_.size()));
  for (const std::vector<uint32_t>& edges : of_blocker) {
    first_edges_.push_back(static_cast<uint32_t>(edges_.size()));
    edges_.insert(edges_.end(), edges.begin(), edges.end());
  }
  first_edges_.push_back(static_cast<uint32_t>(edges_.size()));
}

}  // namespace viewpeel
