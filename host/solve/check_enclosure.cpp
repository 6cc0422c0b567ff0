#include "solve/check_enclosure.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

// Throws where emissivities do not suit the bands: a grey row has one emissivity, a row with bands one for each.
void requireEmissivities(const Material& material, size_t band_limits, const std::string& name) {
  const std::vector<double> emissivities =
      band_limits == 0 ? std::vector{material.emissivity} : material.band_emissivities;
  if (emissivities.size() != band_limits + 1)
    throw Error(ErrorCode::bad_usage, fmt::format("'{}' has {} emissivities for {} bands; give one for each", name,
                                                  emissivities.size(), band_limits + 1));
  for (const double emissivity : emissivities)
    if (!(emissivity > 0 && emissivity <= 1))
      throw Error(ErrorCode::bad_usage,
                  fmt::format("'{}' has an emissivity of {}, not above 0 and up to 1; correct it", name, emissivity));
}

}  // namespace

void requireMaterials(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids) {
  if (enclosure.materials.size() != ids.count())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{} materials for {} rows; give one for each", enclosure.materials.size(), ids.count()));
  for (uint32_t i = 0; i < ids.count(); ++i) {
    const Material& material = enclosure.materials[i];
    requireEmissivities(material, enclosure.band_limits_um.size(), ids.names[i]);
    if (material.temperature.has_value() == material.heat_flux.has_value())
      throw Error(ErrorCode::bad_usage,
                  fmt::format("'{}' needs either a temperature or a heat flux; give one of the two", ids.names[i]));
  }
  if (closed.is_open && !enclosure.environment_temperature && !enclosure.sky_and_ground)
    throw Error(
        ErrorCode::bad_input,
        fmt::format("{:.3g} % of all emitted radiation leaves the scene; give its surroundings a temperature by "
                    "a line 'environment' in the materials (0 for empty space), or close the scene",
                    100 * closed.environment_share));
}

void refuseWithoutReference(const std::string& name) {
  throw Error(ErrorCode::bad_input,
              fmt::format("the temperature of '{}' is open: it and all rows that it exchanges heat with have heat "
                          "fluxes only; give one of them a temperature",
                          name));
}

void requireReferences(const ClosedExchange& closed, const Enclosure& enclosure, const Ids& ids) {
  std::vector<uint32_t> group(ids.count());
  std::iota(group.begin(), group.end(), 0u);
  const auto find = [&](uint32_t k) {
    while (group[k] != k) k = group[k] = group[group[k]];
    return k;
  };
  for (uint32_t i = 0; i < ids.count(); ++i)
    for (decltype(closed.pairs)::InnerIterator at(closed.pairs, i); at; ++at)
      if (at.value() > 0) group[find(static_cast<uint32_t>(at.col()))] = find(i);
  std::vector<bool> refers(ids.count());
  for (uint32_t i = 0; i < ids.count(); ++i)
    if (enclosure.materials[i].temperature || closed.environment[i] > 0) refers[find(i)] = true;
  for (uint32_t i = 0; i < ids.count(); ++i)
    if (!refers[find(i)]) refuseWithoutReference(ids.names[i]);
}

bool areAllFluxesGiven(const Enclosure& enclosure) {
  return std::ranges::all_of(enclosure.materials,
                             [](const Material& material) { return material.heat_flux.has_value(); });
}

void requireTolerance(const HeatTolerance& tolerance, const Enclosure& enclosure) {
  if (!(tolerance.standard_error > 0)) throw Error(ErrorCode::bad_usage, "the tolerance is not above 0; give a larger");
  if (tolerance.of == HeatTolerance::Of::temperature &&
      std::ranges::all_of(enclosure.materials,
                          [](const Material& material) { return material.temperature.has_value(); }))
    throw Error(ErrorCode::bad_usage,
                "all temperatures are given, so that none has an error; ask for a tolerance in W/m2 or as a share");
  if (tolerance.of != HeatTolerance::Of::temperature && areAllFluxesGiven(enclosure))
    throw Error(ErrorCode::bad_usage,
                "all heat fluxes are given, so that none has an error; ask for a tolerance in K, as in 0.1K");
}

}  // namespace viewpeel
