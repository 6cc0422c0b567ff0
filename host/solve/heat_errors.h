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
  // Returns the standard error of sum_k factor_k H_k, with H_k the irradiation of terms[k].row.
  virtual double standardError(const std::vector<Term>& terms) const = 0;
  // A Part of the environment is the whole, or its part above or below the horizon.
  enum class Part { all, up, down };
  // Returns the standard error of the heat flow to a part of the environment, sum_i x_ip (B_i - B_p), W. Here x_ip is
  // row i's exchange area with part p, B_i its radiosity, and B_p the emissive power of the part.
  //   In: reflectivity: by row
  virtual double environmentError(const Eigen::VectorXd& reflectivity, Part part = Part::all) const = 0;
};

// HeatErrors computes standard errors of sums sum_k c_k H_k of irradiations.
//   An answer may depend on few pairs. So its variance is a sum over all pairs, of their errors in sums, and the
//   largest margin of one pair.
//   Up to kMostExactRows rows they follow from the inverse matrix. With more rows there are kProbes sets of random
//   signs, a sign for each pair's error. The mean square over these probes is the variance, to 1/16 of the standard
//   error. The margin is then of the answer's own rows, without what other rows reflect.
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
  // A Source is the error of one exchange area x_ij. If x_ij is off by its standard error, A_i H_i changes by of_i, and
  // A_j H_j by of_j: z_i and z_j of docs/solve.md, eq. (7).
  struct Source {
    uint32_t i, j;
    double of_i, of_j;
    double x_ie, x_je;  // change of the rows' exchange with the environment
    // The variance that errors in sums leave out, over the variance that they have: what the pair's few lines may have
    // missed, where all of them agree.
    double margin;
  };
  // A Functional says how an answer changes with errors, to first order. A disturbance z of A H changes it by
  // sum_k adjoint_k z_k. Until environmentError() applies the inverse, adjoint_k is the change per unit of H_k instead.
  // of_environment is the change per unit of a row's exchange area with the environment, and of_up
  // per unit of exchange area that moves from below the horizon to above.
  struct Functional {
    Eigen::VectorXd adjoint, of_environment, of_up;
  };
  double rootOfSquares(const Functional& functional) const;
  Functional environmentFlow(const Eigen::VectorXd& reflectivity, Part part) const;

  const ClosedExchange& closed_;
  const Outside& outside_;
  Eigen::VectorXd radiosity_;
  std::vector<Source> sources_;
  std::vector<double> margins_;  // with probes, by row: largest margin x of_i^2 of its pairs, W^2
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inverse_;  // empty where probes are used
  // Both are rows x columns: kProbes columns, then one for each error of the outside. A column of probes_ is the effect
  // on irradiations, and one of to_environment_ the effect on exchange areas with the environment.
  Eigen::MatrixXd probes_, to_environment_;
};

}  // namespace viewpeel
