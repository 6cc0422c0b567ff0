#include "scene/group_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include <glm/glm.hpp>

#include "scene/perimeter.h"

namespace viewpeel {
namespace {

// A PlaneIndex finds planes by normal and offset. It keeps them in cells of normals, and within a cell sorted by
// offset. Cells are so wide that nearly parallel planes lie in the same cell or in neighbouring cells.
class PlaneIndex {
 public:
  void add(const Plane& plane, uint32_t index) { cells_[cellOf(plane.normal)].emplace(plane.offset, index); }

  // Calls use(index) for all planes with a normal within half a cell of `normal` and an offset within `reach` of
  // `offset`.
  template <class Use>
  void forEachNear(const glm::dvec3& normal, double offset, double reach, Use use) const {
    const Cell low = cellOf(normal - kCell / 2), high = cellOf(normal + kCell / 2);
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) {
          const auto cell = cells_.find({x, y, z});
          if (cell == cells_.end()) continue;
          for (auto at = cell->second.lower_bound(offset - reach);
               at != cell->second.end() && at->first <= offset + reach; ++at)
            use(at->second);
        }
  }

 private:
  using Cell = std::array<int, 3>;
  static constexpr double kCell = 1e-3;
  static Cell cellOf(const glm::dvec3& n) {
    return {int(std::floor(n.x / kCell)), int(std::floor(n.y / kCell)), int(std::floor(n.z / kCell))};
  }
  std::map<Cell, std::multimap<double, uint32_t>> cells_;
};

// Returns the largest distance of a corner from the plane.
double distanceFrom(const Plane& plane, const Scene& scene, const Polygon& polygon) {
  double distance = 0;
  for (uint32_t k = 0; k < polygon.corner_count; ++k)
    distance =
        std::max(distance, std::abs(glm::dot(plane.normal, scene.corners[polygon.first_corner + k]) - plane.offset));
  return distance;
}

}  // namespace

Plane planeOf(const Scene& scene, const Polygon& polygon) {
  const glm::dvec3* corners = &scene.corners[polygon.first_corner];
  glm::dvec3 centre(0);
  for (uint32_t k = 0; k < polygon.corner_count; ++k) centre += corners[k] / double(polygon.corner_count);
  const glm::dvec3 normal = frontNormal(scene, polygon);
  return {normal, glm::dot(normal, centre)};
}

void groupPlanes(Scene& scene) {
  std::vector<uint32_t> by_area(scene.polygons.size());
  std::iota(by_area.begin(), by_area.end(), 0u);
  std::stable_sort(by_area.begin(), by_area.end(),
                   [&](uint32_t a, uint32_t b) { return scene.polygons[a].area > scene.polygons[b].area; });
  PlaneIndex index;
  for (uint32_t polygon_index : by_area) {
    Polygon& polygon = scene.polygons[polygon_index];
    const Plane polygon_plane = planeOf(scene, polygon);
    // A polygon of width w whose corners are within the tolerance of a plane may be tilted by twice the tolerance over
    // w.
    const double width = polygon.area / perimeterOf(scene, polygon);
    const double reach = kCoplanarTolerance + std::min(2 * kCoplanarTolerance / width, 1e-3);
    uint32_t found = UINT32_MAX;
    for (double sign : {1.0, -1.0})
      index.forEachNear(sign * polygon_plane.normal, sign * polygon_plane.offset, reach, [&](uint32_t candidate) {
        if (candidate < found && distanceFrom(scene.planes[candidate], scene, polygon) <= kCoplanarTolerance)
          found = candidate;
      });
    if (found == UINT32_MAX) {
      found = static_cast<uint32_t>(scene.planes.size());
      scene.planes.push_back(polygon_plane);
      index.add(polygon_plane, found);
    }
    polygon.plane = found;
    polygon.front_along_plane_normal = glm::dot(scene.planes[found].normal, polygon_plane.normal) > 0;
  }
}

}  // namespace viewpeel
