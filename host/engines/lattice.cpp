#include "engines/lattice.h"

#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engines/shared.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

static_assert(device_data::kEmits == kEmits && device_data::kReceives == kReceives);

template <class T>
Buffer uploadBuffer(const Device& device, const std::vector<T>& values, VkFormat texels = VK_FORMAT_UNDEFINED) {
  Buffer buffer(device, values.size() * sizeof(T), MemoryUse::upload, texels);
  buffer.write<T>(values);
  return buffer;
}

std::vector<device_data::PolygonData> listPolygons(const Scene& scene, const Ids& ids) {
  std::vector<device_data::PolygonData> polygons;
  polygons.reserve(scene.polygons.size());
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const Polygon& polygon = scene.polygons[k];
    const Plane& plane = scene.planes[polygon.plane];
    const uint32_t id = ids.of_polygon[k] | ids.rolesOf(static_cast<uint32_t>(k)) << device_data::kRolesShift;
    polygons.push_back({polygon.first_corner, polygon.corner_count, id, polygon.tie_rank, plane.normal, plane.offset});
  }
  return polygons;
}

std::vector<device_data::CornerData> listCorners(const Scene& scene) {
  std::vector<device_data::CornerData> corners;
  corners.reserve(scene.corners.size());
  for (const glm::dvec3& corner : scene.corners) corners.push_back({corner, 0});
  return corners;
}

}  // namespace

SceneBuffers::SceneBuffers(const Device& device, const Scene& scene, const Ids& ids)
    : polygons(uploadBuffer(device, listPolygons(scene, ids), VK_FORMAT_R32G32B32A32_UINT)),
      corners(uploadBuffer(device, listCorners(scene), VK_FORMAT_R32G32B32A32_UINT)),
      polygon_count(static_cast<uint32_t>(scene.polygons.size())) {}

int chooseFractionBits(int resolution, const Window& window) {
  if (resolution < 1 || resolution > kMaxWindowResolution ||
      windowReach(resolution, window) > windowReach(kMostWindowPoints))
    throw Error(ErrorCode::bad_usage,
                fmt::format("resolution {} is out of range; choose 1 to {}", resolution, kMaxResolution));
  const auto farthest = static_cast<uint32_t>(resolution / 2) +
                        static_cast<uint32_t>(std::ceil(resolution / 2.0 * glm::length(window.centre))) + 1;
  return device_data::kSnapBits - std::bit_width(farthest);
}

int windowReach(int resolution, const Window& window) {
  return static_cast<int>(std::floor(resolution / 2.0 * window.radius)) + 2;
}

double expectedPoints(Sampling sampling, double area, double h) {
  return sampling == Sampling::scanline ? std::sqrt(area / 2) / h : area / 2 / (h * h);
}

glm::dvec2 latticeOrigin(const Direction& direction, int resolution, const Window& window) {
  const glm::dvec2 middle =
      resolution / 2.0 *
      glm::dvec2(glm::dot(window.centre, direction.x_axis), glm::dot(window.centre, direction.y_axis));
  return direction.offset - glm::floor(direction.offset + middle);  // moved by whole spacings
}

void writeDirections(std::span<const Direction> directions, int resolution, const Window& window, Buffer& buffer,
                     uint64_t first, uint64_t block_directions) {
  std::span<device_data::DirectionData> data = buffer.mapped<device_data::DirectionData>();
  for (size_t k = 0; k < directions.size(); ++k) {
    const Direction& direction = directions[k];
    data[k] = {direction.x_axis, direction.y_axis,
               direction.u,      latticeOrigin(direction, resolution, window),
               direction.weight, static_cast<uint32_t>((first + k) / block_directions)};
  }
}

}  // namespace viewpeel
