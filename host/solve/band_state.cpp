#include "solve/band_state.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Returns the temperature whose emission is subtracted from all: the environment's, or the first that is given.
double referenceTemperature(const ClosedExchange& closed, const Enclosure& enclosure) {
  if (closed.is_open)
    return enclosure.sky_and_ground ? enclosure.sky_and_ground->up : *enclosure.environment_temperature;
  for (const Material& material : enclosure.materials)
    if (material.temperature) return *material.temperature;
  return 0;
}

}  // namespace

BandState::BandState(const ClosedExchange& closed, const Enclosure& of_rows)
    : enclosure(of_rows), reference(referenceTemperature(closed, of_rows)) {
  const auto n = static_cast<Index>(enclosure.materials.size());
  for (size_t k = 0; k <= enclosure.band_limits_um.size(); ++k) {
    bands.push_back({k == 0 ? 0 : enclosure.band_limits_um[k - 1],
                     k == enclosure.band_limits_um.size() ? INFINITY : enclosure.band_limits_um[k]});
    shifts.push_back(bandPower(bands[k], reference));
    VectorXd emissivity(n);
    for (Index i = 0; i < n; ++i) emissivity[i] = enclosure.materials[static_cast<size_t>(i)].band_emissivities[k];
    emissivities.push_back(std::move(emissivity));
    outside.push_back(makeOutside(closed, enclosure, [&](double temperature) { return power(k, temperature); }));
  }
  temperatures = VectorXd::Constant(n, reference);
  for (Index i = 0; i < n; ++i)
    if (!isFree(i)) temperatures[i] = *enclosure.materials[static_cast<size_t>(i)].temperature;
}

bool BandState::hasFreeRows() const {
  return std::ranges::any_of(enclosure.materials, [](const Material& material) { return !material.temperature; });
}

VectorXd BandState::radiosity(size_t k) const {
  VectorXd radiosity = irradiations[k] - emissivities[k].cwiseProduct(irradiations[k]);
  for (Index i = 0; i < radiosity.size(); ++i) radiosity[i] += emissivities[k][i] * power(k, temperatures[i]);
  return radiosity;
}

VectorXd BandState::slope(size_t k) const {
  VectorXd slope = VectorXd::Zero(temperatures.size());
  for (Index i = 0; i < slope.size(); ++i)
    if (isFree(i)) slope[i] = emissivities[k][i] * powerSlope(k, temperatures[i]);
  return slope;
}

void BandState::refuseNegativeEmission(const std::vector<std::string>& names) const {
  for (Index i = 0; i < temperatures.size(); ++i) {
    if (!isFree(i)) continue;
    double emitted = heatFlux(i);
    for (size_t k = 0; k < bands.size(); ++k) emitted += emissivities[k][i] * (irradiations[k][i] + shifts[k]);
    if (emitted < 0)
      throw Error(ErrorCode::bad_input,
                  fmt::format("'{}' would have to emit {:.4g} W/m2, less than nothing: its heat flux takes more than "
                              "arrives; lower it",
                              names[static_cast<size_t>(i)], emitted));
  }
}

}  // namespace viewpeel
