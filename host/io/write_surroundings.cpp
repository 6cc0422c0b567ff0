// writeSurroundings() writes SurfaceProperty:SurroundingSurfaces and SurfaceProperty:LocalEnvironment for EnergyPlus,
// as IDF or epJSON.
//     Source: EnergyPlus Input Output Reference, and its schema; HeatBalanceSurfaceManager.cc, which refuses sums > 1.
#include <algorithm>
#include <limits>
#include <set>

#include <fmt/ostream.h>
#include <nlohmann/json.hpp>

#include <viewpeel/error.h>
#include <viewpeel/sparse_rows.h>
#include "io/shown_rows.h"
#include "io/writers.h"
#include "scene/energyplus.h"
#include "scene/energyplus_objects.h"
#include "scene/sky_share.h"

namespace viewpeel {
namespace {

// Surroundings are what one surface sees: sky, ground, and others by the names of their rows.
struct Surroundings {
  std::string surface;
  double sky = 0, ground = 0;
  std::vector<std::pair<std::string, double>> others;

  // Scales the view factors to a sum of 1 where sampling or rounding made it more.
  void limit() {
    double sum = sky + ground;
    for (const auto& other : others) sum += other.second;
    if (sum <= 1) return;
    // EnergyPlus rounds each number and each of its sums, so the sum stays a little below 1.
    const double scale = (1 - 2 * double(others.size() + 2) * std::numeric_limits<double>::epsilon()) / sum;
    sky *= scale, ground *= scale;
    for (auto& other : others) other.second *= scale;
  }
  std::string name() const { return "surroundings of " + surface; }
  std::string environment() const { return "environment of " + surface; }
  // Returns the name of a schedule that the user has to provide, for temperatures are not known here.
  static std::string temperature(const std::string& other) { return other + " temperature"; }
};

// Returns the names of surfaces with the boundary condition `outdoors`, in small letters.
std::set<std::string> outdoors(const EnergyPlusBuilding& building) {
  std::set<std::string> names;
  for (const EnergyPlusSurface& surface : building.surfaces)
    if (surface.boundary == "outdoors") names.insert(lowerCase(surface.name));
  return names;
}

std::vector<Surroundings> findSurroundings(const FormFactors& form_factors, const Scene& scene) {
  const Ids& ids = form_factors.ids();
  const std::set<std::string> of_building = outdoors(readEnergyPlus(scene.file));
  const std::vector<uint32_t> id_of_polygon = idsOfPolygons(scene, ids);
  const std::vector<uint32_t> row_of_id = ids.rows();
  const std::vector<std::string> names = rowNames(ids);
  const SparseRows rows = compressRows(form_factors);
  std::vector<Surroundings> found;
  std::vector<uint32_t> seers;
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (!of_building.count(lowerCase(ids.names[id])) || !ids.isRequested(id)) continue;
    const uint32_t row = row_of_id[id];
    Surroundings surroundings{ids.names[id]};
    for (int64_t k = rows.starts[row]; k < rows.starts[row + 1]; ++k)
      if (static_cast<uint32_t>(rows.columns[k]) != row && rows.form_factors[k] > 0)
        surroundings.others.emplace_back(names[static_cast<size_t>(rows.columns[k])], rows.form_factors[k]);
    if (surroundings.others.empty()) continue;
    found.push_back(std::move(surroundings));
    seers.push_back(id);
  }
  std::vector<std::vector<uint32_t>> polygons(seers.size());
  std::vector<uint32_t> place(ids.count(), UINT32_MAX);
  for (uint32_t k = 0; k < seers.size(); ++k) place[seers[k]] = k;
  for (uint32_t polygon = 0; polygon < id_of_polygon.size(); ++polygon)
    if (const uint32_t k = place[id_of_polygon[polygon]]; k != UINT32_MAX) polygons[k].push_back(polygon);
  std::vector<double> environment;
  for (const uint32_t id : seers)
    environment.push_back(std::clamp(form_factors.formFactor(id, kEnvironment).value, 0.0, 1.0));
  const std::vector<SkyShare> shares = divideEnvironment(scene, polygons, environment);
  for (uint32_t k = 0; k < seers.size(); ++k) {
    found[k].sky = shares[k].sky;
    found[k].ground = shares[k].ground;
    found[k].limit();
  }
  return found;
}

void writeSurroundingsIdf(const std::vector<Surroundings>& all, std::ostream& out) {
  for (const Surroundings& of : all) {
    fmt::print(out, "SurfaceProperty:LocalEnvironment,\n  {},\n  {},\n  ,\n  {};\n\n", of.environment(), of.surface,
               of.name());
    fmt::print(out, "SurfaceProperty:SurroundingSurfaces,\n  {},\n  {},\n  ,\n  {},\n  ", of.name(), of.sky, of.ground);
    for (const auto& [other, view_factor] : of.others)
      fmt::print(out, ",\n  {},{},{}", other, view_factor, Surroundings::temperature(other));
    out << ";\n\n";
  }
}

void writeSurroundingsEpJson(const std::vector<Surroundings>& all, std::ostream& out) {
  nlohmann::ordered_json environments = nlohmann::ordered_json::object(), surroundings = environments;
  for (const Surroundings& of : all) {
    environments[of.environment()] = {{"exterior_surface_name", of.surface},
                                      {"surrounding_surfaces_object_name", of.name()}};
    nlohmann::ordered_json others = nlohmann::ordered_json::array();
    for (const auto& [other, view_factor] : of.others)
      others.push_back({{"surrounding_surface_name", other},
                        {"surrounding_surface_view_factor", view_factor},
                        {"surrounding_surface_temperature_schedule_name", Surroundings::temperature(other)}});
    surroundings[of.name()] = {
        {"sky_view_factor", of.sky}, {"ground_view_factor", of.ground}, {"surfaces", std::move(others)}};
  }
  out << nlohmann::ordered_json{{"SurfaceProperty:LocalEnvironment", std::move(environments)},
                                {"SurfaceProperty:SurroundingSurfaces", std::move(surroundings)}}
             .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
      << '\n';
}

}  // namespace

void writeSurroundings(const FormFactors& form_factors, const Scene& scene, bool as_json, std::ostream& out) {
  const std::vector<Surroundings> surroundings = findSurroundings(form_factors, scene);
  if (as_json) writeSurroundingsEpJson(surroundings, out);
  else writeSurroundingsIdf(surroundings, out);
}

}  // namespace viewpeel
