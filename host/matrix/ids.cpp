#include "matrix/ids.h"

#include <fmt/format.h>

#include "error.h"

namespace viewpeel {

std::string faceName(const Scene& scene, uint32_t face_index) {
  const Face& face = scene.faces[face_index];
  const Surface& surface = scene.surfaces[face.surface];
  return surface.face_count == 1 ? surface.name : fmt::format("{}[{}]", surface.name, face.number);
}

Ids makeIds(const Scene& scene, By by, bool two_sided) {
  Ids ids;
  ids.two_sided = two_sided;
  for (const Surface& surface : scene.surfaces)
    if (surface.name == "environment" || surface.name == "leak")
      throw Error(ErrorCode::bad_input, fmt::format("{}: a surface is called '{}', which stands for something else in the result; rename it",
                                                    scene.file, surface.name));
  if (by == By::surface) {
    for (const Surface& surface : scene.surfaces) {
      ids.surface.push_back(ids.count());
      ids.names.push_back(surface.name);
    }
  } else {
    for (uint32_t k = 0; k < scene.faces.size(); ++k) {
      ids.surface.push_back(scene.faces[k].surface);
      ids.names.push_back(faceName(scene, k));
    }
  }
  ids.areas.assign(ids.names.size(), 0.0);
  const double emitting_sides = two_sided ? 2 : 1;
  for (const Polygon& polygon : scene.polygons) {
    const uint32_t id = by == By::surface ? scene.faces[polygon.face].surface : polygon.face;
    ids.of_polygon.push_back(id);
    ids.areas[id] += emitting_sides * polygon.area * scene.scale * scene.scale;
  }
  return ids;
}

}  // namespace viewpeel
