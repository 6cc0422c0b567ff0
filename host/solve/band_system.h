// A BandSystem solves the equations of all bands of wavelengths, and tells how answers respond to disturbances:
// docs/solve.md, eq. (12) and (13).
#pragma once
#include <memory>
#include <vector>

#include <viewpeel/solve.h>
#include "solve/band_errors.h"
#include "solve/band_state.h"
#include "solve/irradiation.h"

namespace viewpeel {

// A BandSystem solves A H_k = X B_k + x_e S_k and B_k = e_k E_k(T) + (1 - e_k) H_k for each band k of wavelengths. A is
// the diagonal matrix of areas, X holds the exchange areas between rows, and x_e each row's with the environment. H_k,
// B_k and e_k are irradiations, radiosities and emissivities. E_k(T) is the emission of a black surface, and S_k the
// irradiation from the environment. A row of given heat flux has the temperature T at which sum_k e_k (E_k(T) - H_k)
// is this flux.
class BandSystem {
 public:
  //   In: closed, enclosure: kept by reference; materials: checked
  BandSystem(const ClosedExchange& closed, const Enclosure& enclosure);

  // Finds the temperatures of all rows by Newton's method, and with them the irradiations.
  //   Throws: Error bad_input where a row would have to emit less than nothing; Error limit where Newton's method or
  //    conjugate gradients do not converge.
  void solve(const std::vector<std::string>& names);

  const BandState& state() const { return state_; }
  uint32_t steps() const;

  // Returns the response to a disturbance of A H_k in each band k. Several threads may call it at once.
  //   In: disturbances: by band and row, W    Error: 1e-7 of the disturbance.
  BandResponse respond(const BandVectors& disturbances) const;

 private:
  Eigen::VectorXd solveRoughly(size_t k, const Eigen::VectorXd& b) const;
  void findIrradiations();
  Eigen::VectorXd excess() const;
  void guessTemperatures();
  Eigen::VectorXd changeOfFlux(const BandVectors& slopes, const Eigen::VectorXd& change) const;
  Eigen::VectorXd solveNewton(const Eigen::VectorXd& right_side) const;

  const ClosedExchange& closed_;
  BandState state_;
  std::vector<std::shared_ptr<const Irradiation>> solvers_;  // by band; bands with the same emissivities share one
  using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<std::shared_ptr<const RowMajorMatrix>> inverses_;  // by band; empty with more than kMostExactRows rows
};

}  // namespace viewpeel
