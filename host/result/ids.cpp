#include <viewpeel/ids.h>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "scene/face_names.h"

namespace viewpeel {

std::vector<uint32_t> Ids::rows() const {
  std::vector<uint32_t> rows(count());
  size_t passed = 0;
  for (uint32_t id = 0; id < count(); ++id) {
    while (passed < empty_rows.size() && empty_rows[passed].row == id + passed) ++passed;
    rows[id] = id + static_cast<uint32_t>(passed);
  }
  return rows;
}

Ids makeIds(const Scene& scene, By by, bool two_sided) {
  Ids ids;
  ids.empty_rows = by == By::surface ? scene.empty_surfaces : scene.empty_faces;
  ids.two_sided = two_sided;
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
  for (const Polygon& polygon : scene.polygons) {
    const uint32_t id = by == By::surface ? scene.faces[polygon.face].surface : polygon.face;
    ids.of_polygon.push_back(id);
    ids.areas[id] += ids.sides() * polygon.area * scene.scale * scene.scale;
  }
  return ids;
}

std::vector<uint32_t> findPolygons(const Scene& scene, const std::string& name) {
  std::vector<uint32_t> found;
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t face = scene.polygons[k].face;
    const Surface& surface = scene.surfaces[scene.faces[face].surface];
    if (surface.name == name || faceName(scene, face) == name ||
        fmt::format("{}[{}]", surface.name, scene.faces[face].number) == name)
      found.push_back(k);
  }
  if (found.empty()) {
    std::vector<std::string> names;
    std::vector<uint32_t> counts;
    for (const Surface& surface : scene.surfaces) names.push_back(surface.name), counts.push_back(surface.face_count);
    throw Error(ErrorCode::bad_usage, fmt::format("{}: no surface or face is called '{}'; {}", scene.file, name,
                                                  explainUnknownName(name, names, counts)));
  }
  return found;
}

void restrictToQuestion(const Question& question, const Scene& scene, Ids& ids) {
  if (question.isEverything()) return;
  if (!question.pair.empty() && !question.from.empty())
    throw Error(ErrorCode::bad_usage, "--pair and --from ask for different things; use one of them");
  if (!question.pair.empty() && question.pair.size() != 2)
    throw Error(ErrorCode::bad_usage, "--pair takes two names of surfaces or faces");
  ids.roles.assign(scene.polygons.size(), question.pair.empty() ? kReceives | (question.from.empty() ? kEmits : 0) : 0);
  const auto give = [&](const std::string& name, uint32_t role) {
    for (uint32_t polygon : findPolygons(scene, name)) ids.roles[polygon] |= role;
  };
  for (const std::string& name : question.from) give(name, kEmits);
  if (!question.pair.empty()) {
    give(question.pair.at(0), kEmits);
    give(question.pair.at(1), kReceives);
    ids.counts_environment = false;
  }
  ids.requested.assign(ids.count(), question.from.empty() && question.pair.empty());
  for (uint32_t k = 0; k < scene.polygons.size(); ++k)
    if (ids.roles[k] & kEmits || (ids.roles[k] && !question.pair.empty())) ids.requested[ids.of_polygon[k]] = true;
  if (!question.blockers.empty()) ids.only_blocks.assign(ids.count(), false);
  for (const std::string& name : question.blockers)
    for (uint32_t polygon : findPolygons(scene, name)) {
      if ((!question.from.empty() && (ids.roles[polygon] & kEmits)) || (!question.pair.empty() && ids.roles[polygon]))
        throw Error(ErrorCode::bad_usage,
                    fmt::format("'{}' is asked for and also given as --blocker; leave out one of the two", name));
      ids.roles[polygon] = 0;
      ids.requested[ids.of_polygon[polygon]] = false;
      ids.only_blocks[ids.of_polygon[polygon]] = true;
    }
  std::vector<uint32_t> roles_of_id(ids.count(), UINT32_MAX), roles_of_surface(scene.surfaces.size(), UINT32_MAX);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    uint32_t& of_id = roles_of_id[ids.of_polygon[k]];
    uint32_t& of_surface = roles_of_surface[scene.faces[scene.polygons[k].face].surface];
    if (of_id != UINT32_MAX && of_id != ids.roles[k])
      throw Error(ErrorCode::bad_usage,
                  fmt::format("only a part of '{}' was named, which has one row; use --by polygon",
                              ids.names[ids.of_polygon[k]]));
    ids.splits_surfaces = ids.splits_surfaces || (of_surface != UINT32_MAX && of_surface != ids.roles[k]);
    of_id = of_surface = ids.roles[k];
  }
  ids.rows_sum_to_one = question.pair.empty() && question.blockers.empty();
}

}  // namespace viewpeel
