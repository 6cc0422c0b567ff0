// Tests of heat use these enclosures, whose form factors are closed forms.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include <viewpeel/solve.h>

namespace viewpeel::test_enclosures {

// Returns form factors with these exchange areas and standard errors. Row sums are the sums of entries.
inline FormFactors formFactors(const std::vector<double>& areas, std::vector<FormFactors::Entry> entries) {
  Ids ids;
  ids.areas = areas;
  std::vector<Measured> rows(areas.size());
  for (uint32_t i = 0; i < areas.size(); ++i) {
    ids.names.push_back("row" + std::to_string(i));
    ids.surface.push_back(i);
  }
  for (const FormFactors::Entry& entry : entries) {
    rows[entry.i].value += entry.exchange_area.value / areas[entry.i];
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].value += entry.exchange_area.value / areas[entry.j];
  }
  return {std::move(ids), std::move(entries), std::move(rows)};
}

inline Material hot(double emissivity, double temperature) { return {emissivity, temperature, {}}; }
inline Material flux(double emissivity, double heat_flux) { return {emissivity, {}, heat_flux}; }

inline double power(double temperature) { return kStefanBoltzmann * std::pow(temperature, 4); }

// Returns the heat flow, W, from a surface to one around it. The inner one sees only the outer one, which also sees
// itself (Oppenheim).
inline double betweenTwo(double area, double emissivity, double temperature, double outer_area, double outer_emissivity,
                         double outer_temperature) {
  return (power(temperature) - power(outer_temperature)) /
         (1 / (area * emissivity) + (1 - outer_emissivity) / (outer_area * outer_emissivity));
}

inline Enclosure enclosureOf(const FormFactors& form_factors, std::vector<Material> materials) {
  return {std::move(materials), {}, form_factors.ids().names};
}

}  // namespace viewpeel::test_enclosures
