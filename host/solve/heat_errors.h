// HeatErrors propagate errors of form factors to irradiations, in first order: docs/solve.md, eq. (7) and (8).
#pragma once
#include <vector>

#include "solve/irradiation.h"
#include "solve/outside.h"

namespace viewpeel {

constexpr uint32_t kMostExactRows = 1000;
constexpr uint32_t kProbes = 128;

// CarriedErrors have the standard errors of answers, which are sums over irradiations.
class CarriedErrors {
 public:
  struct Term {
    uint32_t row;
    double factor;
  };
  virtual ~CarriedErrors() = default;
  // Returns the standard error of sum_k factor_k H_k.
  virtual double standardError(const std::vector<Term>& terms) const = 0;
  // A Part of the environment is the whole, or its part above or below the horizon.
  enum class Part { all, up, down };
  // Returns the standard error of the heat flow to a part of the environment, sum_i x_ip (B_i - B_p).
  //   In: reflectivity: by row
  virtual double environmentError(const Eigen::VectorXd& reflectivity, Part part = Part::all) const = 0;
};

// HeatErrors computes standard errors of sums sum_k c_k H_k of irradiations.
//   Up to kMostExactRows rows they follow from the inverse matrix. With more rows there are kProbes sets of random
//   signs, a sign for each pair's error. The mean square over these probes is the variance, to 1/16 of the standard
//   error.
class HeatErrors : public CarriedErrors {
 public:
  //   In: measured: entries with standard errors, taken as independent; closed: made of them; irradiation: with the
  //    solution's reflectivities; radiosity: by row; outside; both less the solution's shift. References to closed,
  //    irradiation and outside are kept
  //   Cost: Irradiation::inverse, or kProbes times Irradiation::solve.
  HeatErrors(const FormFactors& measured, const ClosedExchange& closed, const Irradiation& irradiation,
             const Eigen::VectorXd& radiosity, const Outside& outside, uint32_t most_exact_rows = kMostExactRows);

  //   Error: of first order in the errors of form factors; with probes 1/16. Tests: tests/unit/solve_errors_test.cpp,
  //    against the spread of perturbed solutions.
  //   Cost: O(pairs + rows x terms), or O(kProbes x terms).
  double standardError(const std::vector<Term>& terms) const override;
  double environmentError(const Eigen::VectorXd& reflectivity, Part part = Part::all) const override;

 private:
  // A Source is one exchange area's error. A standard error changes A_i H_i by of_i, and A_j H_j by of_j.
  struct Source {
    uint32_t i, j;
    double of_i, of_j;
    double x_ie, x_je;  // change of the rows' exchange with the environment
  };
  // A Functional is a sum that depends on a disturbance z as sum_k adjoint_k z_k. It also depends on each row's change
  // of exchange with the environment, by of_environment. Exchange that moves from below the horizon to above counts by
  // of_up.
  struct Functional {
    Eigen::VectorXd adjoint, of_environment, of_up;
  };
  double rootOfSquares(const Functional& functional) const;
  Functional environmentFlow(const Eigen::VectorXd& reflectivity, Part part) const;

  const ClosedExchange& closed_;
  const Outside& outside_;
  Eigen::VectorXd radiosity_;
  std::vector<Source> sources_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inverse_;  // empty where probes are used
  // Rows x kProbes, then a column for each error of the outside: its effect on H, and on x_ie.
  Eigen::MatrixXd probes_, to_environment_;
};

}  // namespace viewpeel
