#include "result/leak_warnings.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "scene/leaks.h"

namespace viewpeel {
namespace {

constexpr size_t kMostSurfaces = 3;
constexpr double kLeastNamed = 0.01;  // surfaces with less than this share of the leak are not named

// LeakAreas holds the exchange areas that leak, by row and by surface, and the areas of surfaces.
struct LeakAreas {
  std::vector<double> of_id, of_surface, area_of_surface;
  double total = 0, emitted = 0;
  double largest = 0;  // form factor of a row to leak
};

LeakAreas sumLeaks(const Scene& scene, const FormFactors& form_factors) {
  const Ids& ids = form_factors.ids();
  LeakAreas sums{std::vector<double>(ids.count(), 0),
                 std::vector<double>(scene.surfaces.size(), 0),
                 std::vector<double>(scene.surfaces.size(), 0),
                 0,
                 0,
                 0};
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (!ids.isRequested(id)) continue;
    const double leak = form_factors.exchangeArea(id, kLeak).value;
    sums.of_id[id] = leak;
    sums.of_surface[ids.surface[id]] += leak;
    sums.area_of_surface[ids.surface[id]] += ids.areas[id];
    sums.largest = std::max(sums.largest, leak / ids.areas[id]);
    sums.total += leak;
    sums.emitted += ids.areas[id];
  }
  return sums;
}

// Returns a weight for each of Scene::polygons: its share by area of the exchange area of its row's leak.
std::vector<double> weightPolygons(const Scene& scene, const Ids& ids, const LeakAreas& leaks) {
  const bool by_polygon = ids.count() == scene.faces.size();  // or by surface, where every surface has one face
  std::vector<double> weights;
  for (const Polygon& polygon : scene.polygons) {
    const uint32_t id = by_polygon ? polygon.face : scene.faces[polygon.face].surface;
    weights.push_back(polygon.area * leaks.of_id[id] / ids.areas[id]);
  }
  return weights;
}

std::string nameRows(const Scene& scene, const LeakAreas& leaks) {
  std::vector<uint32_t> order(scene.surfaces.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return leaks.of_surface[a] > leaks.of_surface[b]; });
  std::string text;
  size_t count = 0;
  for (uint32_t surface : order) {
    if (!(leaks.of_surface[surface] > kLeastNamed * leaks.total)) break;
    if (count++ < kMostSurfaces)
      text += fmt::format("{}{} loses {:.3g} %", count > 1 ? ", " : "", scene.surfaces[surface].name,
                          100 * leaks.of_surface[surface] / leaks.area_of_surface[surface]);
  }
  return count > kMostSurfaces ? fmt::format("{}, and {} more", text, count - kMostSurfaces) : text;
}

}  // namespace

std::vector<std::string> warnOfLeaks(const Scene& scene, const FormFactors& form_factors, double goal) {
  const Ids& ids = form_factors.ids();
  if (!ids.rows_sum_to_one || ids.two_sided) return {};
  const auto isPair = [](const FormFactors::Entry& entry) { return entry.j < kEnvironment; };
  const LeakAreas leaks = sumLeaks(scene, form_factors);
  const double share = leaks.total / leaks.emitted;
  if (share == 0 && scene.faces.size() > 1 && ids.requested.empty() && !form_factors.entries().empty() &&
      std::none_of(form_factors.entries().begin(), form_factors.entries().end(), isPair))
    return {
        fmt::format("{}: no front sees another front: every line leaves the scene; turn a room whose normals look "
                    "outward by --fix-normals, or surfaces by --flip NAME",
                    scene.file)};
  if (!(share > kClosedLeak || leaks.largest > goal)) return {};  // checked before isClosed(), for kOpenLeak is larger
  const bool is_closed = isClosed(scene);
  if (!(share > (is_closed ? kClosedLeak : kOpenLeak) || leaks.largest > goal)) return {};
  std::vector<std::string> lines = {
      fmt::format("{}: {:.2g} % of what is emitted ends on backs (leak), {}: {}", scene.file, 100 * share,
                  is_closed ? "though all edges are closed" : "and edges are open", nameRows(scene, leaks))};
  const FrontRays rays = followFronts(scene, weightPolygons(scene, ids, leaks));
  if (rays.leaks.empty())
    lines.push_back(
        fmt::format("{}: the backs are not known: none of {} rays from fronts hit a back", scene.file, rays.rays));
  for (std::string& line : describeLeaks(scene, rays.leaks)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace viewpeel
