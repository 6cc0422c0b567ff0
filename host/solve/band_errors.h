// Errors of form factors are carried to answers of enclosures with bands of wavelengths, in first order.
#pragma once
#include <vector>

#include "solve/band_system.h"

namespace viewpeel {

constexpr size_t kMostSources = 512;

// BandErrors know how errors of exchange areas change all answers of rows: one column for each error, or for each of
// kProbes sets of random signs where there are more errors. Columns of sky and ground apart come last.
//   Error: of first order; with probes, 1/16 of the standard error. Tests: tests/unit/solve_bands_test.cpp.
class BandErrors {
 public:
  //   In: measured, closed, system: after solve(); referred to during the call only; most_sources: errors of exchange
  //     areas beyond which there are probes
  //   Cost: as BandSystem::respond, once a column.
  BandErrors(const FormFactors& measured, const ClosedExchange& closed, const BandSystem& system,
             size_t most_sources = kMostSources);

  // An Answer is a value of each row.
  enum Answer { kTemperature, kEmission, kRadiosity, kIrradiation, kFlux };
  struct Term {
    uint32_t row;
    double factor;
  };
  // Returns the standard error of sum_k factor_k answer_k.    Cost: O(columns x terms).
  double standardError(Answer answer, const std::vector<Term>& terms) const;
  // Returns that of the heat flows to the environment, and to its parts above and below the horizon.
  double toEnvironment() const { return rootOfSquares(to_up_ + to_down_); }
  double toUp() const { return rootOfSquares(to_up_); }
  double toDown() const { return rootOfSquares(to_down_); }

 private:
  double rootOfSquares(const Eigen::VectorXd& changes) const;

  size_t sources_ = 0;                    // columns of errors of exchange areas, or probes
  double weight_ = 1;                     // of these columns
  std::vector<Eigen::MatrixXd> changes_;  // of each Answer: rows x columns
  Eigen::VectorXd to_up_, to_down_;       // of each column
};

}  // namespace viewpeel
