#include "scene/rank_by_place.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>

namespace viewpeel {
namespace {

constexpr double kOrientation = 2;  // factor of the normal's coordinates beside the centroid's

using PolygonPlace = std::array<double, 6>;

void halve(std::span<uint32_t> ids, const std::vector<PolygonPlace>& places) {
  if (ids.size() < 2) return;
  PolygonPlace least, greatest;
  least.fill(std::numeric_limits<double>::infinity());
  greatest.fill(-std::numeric_limits<double>::infinity());
  for (uint32_t id : ids)
    for (size_t axis = 0; axis < least.size(); ++axis) {
      least[axis] = std::min(least[axis], places[id][axis]);
      greatest[axis] = std::max(greatest[axis], places[id][axis]);
    }
  size_t widest = 0;
  for (size_t axis = 1; axis < least.size(); ++axis)
    if (greatest[axis] - least[axis] > greatest[widest] - least[widest]) widest = axis;
  const size_t half = std::bit_ceil(ids.size()) / 2;
  std::nth_element(
      ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(half), ids.end(),
      [&](uint32_t a, uint32_t b) { return std::tuple(places[a][widest], a) < std::tuple(places[b][widest], b); });
  halve(ids.subspan(0, half), places);
  halve(ids.subspan(half), places);
}

}  // namespace

std::vector<uint32_t> rankByPlace(const Scene& scene, const std::vector<uint32_t>& id_of_polygon, uint32_t count) {
  std::vector<PolygonPlace> places(count, PolygonPlace{});
  std::vector<double> areas(count, 0);
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    glm::dvec3 middle(0);
    for (uint32_t c = 0; c < polygon.corner_count; ++c)
      middle += scene.corners[polygon.first_corner + c] / double(polygon.corner_count);
    const glm::dvec3 normal =
        scene.planes[polygon.plane].normal * (polygon.front_along_plane_normal ? kOrientation : -kOrientation);
    const double area = polygon.area;
    PolygonPlace& place = places[id_of_polygon[k]];
    for (int axis = 0; axis < 3; ++axis) {
      place[static_cast<size_t>(axis)] += area * middle[axis];
      place[static_cast<size_t>(axis) + 3] += area * normal[axis];
    }
    areas[id_of_polygon[k]] += area;
  }
  for (uint32_t id = 0; id < count; ++id)
    for (double& coordinate : places[id]) coordinate /= areas[id];
  std::vector<uint32_t> ids(count), ranks(count);
  std::iota(ids.begin(), ids.end(), 0u);
  halve(ids, places);
  for (uint32_t rank = 0; rank < count; ++rank) ranks[ids[rank]] = rank;
  return ranks;
}

}  // namespace viewpeel
