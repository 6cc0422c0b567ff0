// Errors of form factors are carried to irradiations, in first order: docs/solve.md, eq. (7) and (8).
#pragma once
#include <vector>

#include "solve/irradiation.h"

namespace viewpeel {

constexpr uint32_t kMostExactRows = 1000;
constexpr uint32_t kProbes = 128;

// HeatErrors has the standard errors of sums sum_k c_k H_k over irradiations.
//   Up to kMostExactRows rows they follow from the inverse. Beyond, from kProbes sets of random signs, one for the
//   error of each pair: the mean square over probes is the variance, known to 1/16 of the standard error.
class HeatErrors {
 public:
  //   In: measured: entries with standard errors, taken for independent; closed: of these; irradiation: of the
  //     solution's reflectivities; radiosity: of rows, less the environment's where there is one
  //   Cost: that of Irradiation::inverse, or kProbes times Irradiation::solve.
  HeatErrors(const FormFactors& measured, const ClosedExchange& closed, const Irradiation& irradiation,
             const Eigen::VectorXd& radiosity, uint32_t most_exact_rows = kMostExactRows);

  struct Term {
    uint32_t row;
    double factor;
  };
  // Returns the standard error of sum_k factor_k H_k.
  //   Error: first order in the errors of form factors, and of a probe's spread. Tests:
  //     tests/unit/solve_errors_test.cpp, against the spread of perturbed solutions.
  //   Cost: O(pairs + rows x terms), or O(kProbes x terms).
  double standardError(const std::vector<Term>& terms) const;
  // Returns the standard error of the heat flow to the environment, sum_i x_ie (B_i - B_e).    In: reflectivity of rows
  double environmentError(const Eigen::VectorXd& reflectivity) const;

 private:
  // The error of one exchange area disturbs A_i H_i by of_i, and A_j H_j by of_j, for each standard error.
  struct Source {
    uint32_t i, j;
    double of_i, of_j;
    double to_environment;  // directly, with B as it is
  };
  double rootOfSquares(const Eigen::VectorXd& adjoint, bool of_environment) const;

  const ClosedExchange& closed_;
  std::vector<Source> sources_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inverse_;  // empty where there are probes
  Eigen::MatrixXd probes_;          // rows x kProbes: what each does to H
  Eigen::VectorXd to_environment_;  // of each probe, directly
};

}  // namespace viewpeel
