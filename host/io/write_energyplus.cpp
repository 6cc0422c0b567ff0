// writeEnergyPlus() writes a ZoneProperty:UserViewFactors:BySurfaceName for each zone, as IDF or epJSON. Versions of
// EnergyPlus before 9.6 have another epJSON key for the zone.
//   Source: EnergyPlus Input Output Reference; HeatBalanceIntRadExchange.cc.
#include <set>

#include <fmt/ostream.h>
#include <nlohmann/json.hpp>

#include <viewpeel/error.h>
#include <viewpeel/sparse_rows.h>
#include "io/writers.h"
#include "scene/energyplus.h"

namespace viewpeel {
namespace {

// Returns the rows of each zone: all surfaces of the zone, or none where the run left the zone out.
std::vector<std::vector<uint32_t>> rowsOfZones(const EnergyPlusBuilding& building,
                                               const std::vector<std::string>& names) {
  std::vector<std::vector<uint32_t>> rows(building.zones.size());
  std::vector<size_t> counts(building.zones.size(), 0);
  const std::vector<uint32_t> zones = zonesOf(building);
  uint32_t row = 0;
  for (size_t k = 0; k < zones.size(); ++k) {
    ++counts[zones[k]];
    if (row < names.size() && names[row] == building.surfaces[k].name) rows[zones[k]].push_back(row++);
  }
  bool is_same = row == names.size();
  for (size_t zone = 0; zone < rows.size(); ++zone)
    is_same = is_same && (rows[zone].empty() || rows[zone].size() == counts[zone]);
  if (!is_same)
    throw Error(ErrorCode::bad_usage, fmt::format("{}: rows are not surfaces of whole zones; compute it with --by "
                                                  "surface, and leave it as it is until the view factors are written",
                                                  building.file));
  return rows;
}

// Returns a row of the matrix with its zeros.
std::vector<double> rowOf(const SparseRows& sparse, uint32_t row) {
  std::vector<double> values(static_cast<size_t>(sparse.rowCount()), 0.0);
  for (int64_t k = sparse.starts[row]; k < sparse.starts[row + 1]; ++k)
    values[sparse.columns[k]] = sparse.form_factors[k];
  return values;
}

void writeIdf(const EnergyPlusBuilding& building, const std::vector<std::string>& names,
              const std::vector<std::vector<uint32_t>>& rows, const SparseRows& sparse, std::ostream& out) {
  for (size_t zone = 0; zone < rows.size(); ++zone) {
    if (rows[zone].empty()) continue;
    fmt::print(out,
               "! from surface, to surface, view factor; surfaces are in the order of the building's file\n"
               "ZoneProperty:UserViewFactors:BySurfaceName,\n  {},\n",
               building.zones[zone].name);
    for (uint32_t i : rows[zone]) {
      const std::vector<double> values = rowOf(sparse, i);
      for (uint32_t j : rows[zone])
        fmt::print(out, "  {},{},{}{}\n", names[i], names[j], values[j], i == rows[zone].back() && j == i ? ";" : ",");
    }
    out << '\n';
  }
}

void writeEpJson(const EnergyPlusBuilding& building, const std::vector<std::string>& names,
                 const std::vector<std::vector<uint32_t>>& rows, const SparseRows& sparse, std::ostream& out) {
  const char* zone_key =
      isBeforeSpaces(building) ? "zone_or_zonelist_name" : "zone_or_zonelist_or_space_or_spacelist_name";
  nlohmann::ordered_json objects = nlohmann::ordered_json::object();
  for (size_t zone = 0; zone < rows.size(); ++zone) {
    if (rows[zone].empty()) continue;
    nlohmann::ordered_json factors = nlohmann::ordered_json::array();
    for (uint32_t i : rows[zone]) {
      const std::vector<double> values = rowOf(sparse, i);
      for (uint32_t j : rows[zone])
        factors.push_back({{"from_surface", names[i]}, {"to_surface", names[j]}, {"view_factor", values[j]}});
    }
    objects["view factors of " + building.zones[zone].name] = {{zone_key, building.zones[zone].name},
                                                               {"view_factors", std::move(factors)}};
  }
  out << nlohmann::ordered_json{{"ZoneProperty:UserViewFactors:BySurfaceName", std::move(objects)}}.dump(
             2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
      << '\n';
}

}  // namespace

void checkEnergyPlusRows(const std::filesystem::path& file, const Ids& ids) {
  if (std::set<uint32_t>(ids.surface.begin(), ids.surface.end()).size() != ids.surface.size())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: EnergyPlus has one row for each surface; give --by surface", file.string()));
}

void requireBuilding(const std::filesystem::path& file, const Scene* scene) {
  if (!scene || !isEnergyPlus(scene->file))
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: holds view factors by zone, which only .idf and .epJSON scenes have; write .csv",
                            file.string()));
  std::error_code failure;
  if (std::filesystem::equivalent(file, scene->file, failure))
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: is the scene itself, which would be lost; use another name", file.string()));
}

void writeEnergyPlus(const OutputContent& content, bool as_json, std::ostream& out) {
  const FormFactors& form_factors = content.balanced ? *content.balanced : content.form_factors;
  if (content.scene->is_outside) return writeSurroundings(form_factors, *content.scene, as_json, out);
  const EnergyPlusBuilding building = readEnergyPlus(content.scene->file);
  const std::vector<std::string> names = rowNames(form_factors.ids());
  const std::vector<std::vector<uint32_t>> rows = rowsOfZones(building, names);
  const SparseRows sparse = compressRows(form_factors);
  if (as_json) writeEpJson(building, names, rows, sparse, out);
  else writeIdf(building, names, rows, sparse, out);
}

}  // namespace viewpeel
