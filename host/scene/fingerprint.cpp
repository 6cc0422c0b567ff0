#include "hash.h"
#include <viewpeel/scene.h>

namespace viewpeel {

uint64_t fingerprint(const Scene& scene) {
  Hash hash;
  const auto addPoint = [&](const glm::dvec3& x) {
    for (int axis = 0; axis < 3; ++axis) hash.add(x[axis]);
  };
  hash.add(scene.corners.size());
  for (const glm::dvec3& corner : scene.corners) addPoint(corner);
  hash.add(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons) {
    for (uint32_t index : {polygon.first_corner, polygon.corner_count, polygon.face, polygon.plane}) hash.add(index);
    hash.add(polygon.front_along_plane_normal);
    hash.add(polygon.area);
    if (polygon.tie_rank != kContactRank) hash.add(polygon.tie_rank);
  }
  hash.add(scene.faces.size());
  for (const Face& face : scene.faces) {
    hash.add(face.surface);
    hash.add(face.number);
  }
  hash.add(scene.surfaces.size());
  for (const Surface& surface : scene.surfaces) {
    hash.add(surface.name);
    hash.add(surface.face_count);
  }
  for (const std::vector<EmptyRow>* rows : {&scene.empty_faces, &scene.empty_surfaces})
    for (const EmptyRow& empty : *rows) {
      hash.add(empty.row);
      hash.add(empty.name);
    }
  hash.add(scene.planes.size());
  for (const Plane& plane : scene.planes) {
    addPoint(plane.normal);
    hash.add(plane.offset);
  }
  addPoint(scene.centre);
  hash.add(scene.scale);
  return hash.value();
}

}  // namespace viewpeel
