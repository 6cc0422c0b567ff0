// A BlockerMesh tells which blockers share an edge.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include <viewpeel/scene.h>

namespace viewpeel {

// The outline of a blocker is kept as edges of the polygons that were joined to it. Neighbours share these edges; the
// blocker's own edges may be longer.
class BlockerMesh {
 public:
  //   In: of_polygon: the blocker of each polygon    Cost: O(n log n).
  BlockerMesh(const Scene& scene, std::span<const uint32_t> of_polygon, size_t blocker_count);

  size_t edgeCount() const { return ends_.size(); }
  // Returns the edges of a blocker's outline: the edges that an odd number of its polygons have.
  std::span<const uint32_t> edgesOf(uint32_t blocker) const {
    return {&edges_[first_edges_[blocker]], first_edges_[blocker + 1] - first_edges_[blocker]};
  }
  // Returns the blockers with this edge.
  std::span<const uint32_t> usersOf(uint32_t edge) const {
    return {&users_[first_users_[edge]], first_users_[edge + 1] - first_users_[edge]};
  }
  const std::array<glm::dvec3, 2>& endsOf(uint32_t edge) const { return ends_[edge]; }

 private:
  std::vector<std::array<glm::dvec3, 2>> ends_;
  std::vector<uint32_t> edges_, first_edges_;  // of blockers
  std::vector<uint32_t> users_, first_users_;  // of edges
};

}  // namespace viewpeel
