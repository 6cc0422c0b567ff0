#include "io/shown_rows.h"

#include <algorithm>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {

std::vector<uint32_t> idsOfPolygons(const Scene& scene, const Ids& ids) {
  for (By by : {By::polygon, By::surface}) {
    Ids of_scene = makeIds(scene, by, ids.two_sided);
    if (of_scene.names == ids.names) return std::move(of_scene.of_polygon);
  }
  throw Error(ErrorCode::bad_usage,
              fmt::format("{}: not the scene of these form factors; give the one that was computed", scene.file));
}

std::vector<uint32_t> shownIds(const Scene& scene, const Ids& ids, const std::string& name) {
  std::vector<uint32_t> named_polygons(ids.count(), 0), all_polygons(ids.count(), 0);
  const std::vector<uint32_t> id_of_polygon = idsOfPolygons(scene, ids);
  for (uint32_t id : id_of_polygon) ++all_polygons[id];
  for (uint32_t polygon : findPolygons(scene, name)) ++named_polygons[id_of_polygon[polygon]];
  std::vector<uint32_t> shown;
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (named_polygons[id] == 0) continue;
    if (named_polygons[id] != all_polygons[id])
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("--show {}: only a part of '{}', which has one row; use --by polygon", name, ids.names[id]));
    shown.push_back(id);
  }
  return shown;
}

std::vector<double> formFactorsFrom(const FormFactors& form_factors, const std::vector<uint32_t>& from) {
  const Ids& ids = form_factors.ids();
  std::vector<double> to(ids.count(), 0);
  const auto isFrom = [&](uint32_t id) { return std::ranges::binary_search(from, id); };
  for (const FormFactors::Entry& entry : form_factors.entries()) {
    if (entry.j >= kEnvironment) continue;
    if (isFrom(entry.i)) to[entry.j] += entry.exchange_area.value;
    if (entry.i != entry.j && isFrom(entry.j)) to[entry.i] += entry.exchange_area.value;
  }
  double area = 0;
  for (uint32_t id : from) area += ids.areas[id];
  for (double& value : to) value /= area;
  return to;
}

}  // namespace viewpeel
