// BandErrors propagate errors of form factors to solutions with bands of wavelengths, in first order.
#pragma once
#include <vector>

#include "solve/band_system.h"

namespace viewpeel {

constexpr size_t kMostSources = 512;

// BandErrors hold how errors of exchange areas change all answers: a column for each error. Where there are too many
// errors, there are kProbes columns (heat_errors.h), each for random signs of all errors. Columns for errors of sky and
// ground come last. Derivation: docs/solve.md, eq. (7), (8) and (13).
//   Error: of first order; with probes, 1/16 of the standard error. Tests: tests/unit/solve_bands_test.cpp.
class BandErrors {
 public:
  //   In: measured, closed, system: after solve(), used during the call only; most_sources: with more errors of
  //     exchange areas there are probes
  //   Cost: BandSystem::respond for each column.
  BandErrors(const FormFactors& measured, const ClosedExchange& closed, const BandSystem& system,
             size_t most_sources = kMostSources);

  // An Answer is a quantity that has a value for each row of the solution.
  enum Answer { kTemperature, kEmission, kRadiosity, kIrradiation, kFlux };
  struct Term {
    uint32_t row;
    double factor;
  };
  // Returns the standard error of sum_k factor_k answer_k.    Cost: O(columns x terms).
  double standardError(Answer answer, const std::vector<Term>& terms) const;
  // Returns the standard error of the heat flow to the environment, and to its parts above and below the horizon.
  double toEnvironment() const { return rootOfSquares(to_up_ + to_down_); }
  double toUp() const { return rootOfSquares(to_up_); }
  double toDown() const { return rootOfSquares(to_down_); }

 private:
  double rootOfSquares(const Eigen::VectorXd& changes) const;

  size_t sources_ = 0;                    // number of columns for errors of exchange areas, or of probes
  double weight_ = 1;                     // factor of the squares of these columns
  std::vector<Eigen::MatrixXd> changes_;  // by Answer: rows x columns
  Eigen::VectorXd to_up_, to_down_;       // by column
};

}  // namespace viewpeel
