// A BandState has the temperatures and irradiations of an enclosure whose emissivities depend on the wavelength.
#pragma once
#include <string>
#include <vector>

#include <Eigen/Dense>

#include <viewpeel/solve.h>
#include "solve/blackbody.h"
#include "solve/closed_exchange.h"
#include "solve/outside.h"

namespace viewpeel {

using BandVectors = std::vector<Eigen::VectorXd>;  // a vector over rows for each band

// All powers of band k are less the shift E_k(T_0), so that rows of nearly one temperature lose no digits. T_0 is the
// temperature of the environment, or the first that is given. E_k(T) is the emission of a black surface in band k.
struct BandState {
  // Sets given temperatures, and T_0 for the other rows. Irradiations stay empty.
  //   In: closed: its pairs are not read; enclosure: referred to, with sound materials
  BandState(const ClosedExchange& closed, const Enclosure& enclosure);

  size_t bandCount() const { return bands.size(); }
  // Returns whether a row's temperature is to be found, because its heat flux is given.
  bool isFree(Eigen::Index row) const { return !enclosure.materials[static_cast<size_t>(row)].temperature; }
  bool hasFreeRows() const;
  double heatFlux(Eigen::Index row) const { return *enclosure.materials[static_cast<size_t>(row)].heat_flux; }
  // Returns E_k(T) less the shift, W/m2, and its derivative with respect to T.
  double power(size_t k, double temperature) const { return bandPower(bands[k], temperature) - shifts[k]; }
  double powerSlope(size_t k, double temperature) const { return bandPowerSlope(bands[k], temperature); }
  // Returns what rows emit and reflect in a band, less the shift.
  Eigen::VectorXd radiosity(size_t k) const;
  // Returns the derivative of each free row's emission in a band with respect to its temperature, W/m2 per kelvin; 0
  // for other rows.
  Eigen::VectorXd slope(size_t k) const;
  // Throws Error bad_input for a row that would have to emit less than nothing with these irradiations.
  void refuseNegativeEmission(const std::vector<std::string>& names) const;

  const Enclosure& enclosure;
  double reference;  // T_0, K
  std::vector<Band> bands;
  std::vector<double> shifts;  // by band
  BandVectors emissivities;
  std::vector<Outside> outside;  // by band
  Eigen::VectorXd temperatures;
  BandVectors irradiations;
};

}  // namespace viewpeel
