// Errors of form factors are carried to irradiations, in first order: docs/solve.md, eq. (7) and (8).
#pragma once
#include <vector>

#include "solve/irradiation.h"
#include "solve/outside.h"

namespace viewpeel {

constexpr uint32_t kMostExactRows = 1000;
constexpr uint32_t kProbes = 128;

// HeatErrors has the standard errors of sums sum_k c_k H_k over irradiations.
//   Up to kMostExactRows rows they follow from the inverse. Beyond, from kProbes sets of random signs, one for the
//   error of each pair: the mean square over probes is the variance, known to 1/16 of the standard error.
class HeatErrors {
 public:
  //   In: measured: entries with standard errors, taken for independent; closed: of these; irradiation: of the
  //     solution's reflectivities; radiosity: of rows, less the shift of the solution; outside: less the same; referred
  //     to, but for measured and radiosity
  //   Cost: that of Irradiation::inverse, or kProbes times Irradiation::solve.
  HeatErrors(const FormFactors& measured, const ClosedExchange& closed, const Irradiation& irradiation,
             const Eigen::VectorXd& radiosity, const Outside& outside, uint32_t most_exact_rows = kMostExactRows);

  struct Term {
    uint32_t row;
    double factor;
  };
  // Returns the standard error of sum_k factor_k H_k.
  //   Error: first order in the errors of form factors, and of a probe's spread. Tests:
  //     tests/unit/solve_errors_test.cpp, against the spread of perturbed solutions.
  //   Cost: O(pairs + rows x terms), or O(kProbes x terms).
  double standardError(const std::vector<Term>& terms) const;
  // A Part of the environment is all of it, or what is above or below the horizon.
  enum class Part { all, up, down };
  // Returns the standard error of the heat flow to a part of the environment, sum_i x_ip (B_i - B_p).
  //   In: reflectivity of rows
  double environmentError(const Eigen::VectorXd& reflectivity, Part part = Part::all) const;

 private:
  // The error of one exchange area disturbs A_i H_i by of_i, and A_j H_j by of_j, for each standard error.
  struct Source {
    uint32_t i, j;
    double of_i, of_j;
    double x_ie, x_je;  // what it adds to the rows' exchange with the environment
  };
  // A Functional is sum_k adjoint_k z_k of a disturbance z, and what it does directly: exchange with the environment
  // counts `of_environment` for each row, and what passes from the part below to that above `of_up`.
  struct Functional {
    Eigen::VectorXd adjoint, of_environment, of_up;
  };
  double rootOfSquares(const Functional& functional) const;
  Functional environmentFlow(const Eigen::VectorXd& reflectivity, Part part) const;

  const ClosedExchange& closed_;
  const Outside& outside_;
  Eigen::VectorXd radiosity_;
  std::vector<Source> sources_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inverse_;  // empty where there are probes
  // Rows x kProbes, and then a column for each of the outside's errors: what each does to H, and to x_ie.
  Eigen::MatrixXd probes_, to_environment_;
};

}  // namespace viewpeel
