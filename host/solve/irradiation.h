// An Irradiation computes the irradiations H of all rows, by conjugate gradients on a symmetric positive definite
// matrix.
//
// Rows reflect the shares R of their irradiation. With areas A and closed exchange areas X, (A - X R) H = b. With
// h = R^(1/2) H the matrix S = A - R^(1/2) X R^(1/2) is symmetric. It is positive definite where every row exchanges,
// even through others, with a given temperature. A form with A / R would fail for R = 0. Derivation: docs/solve.md,
// eq. (4) and (5).
#pragma once
#include <Eigen/Dense>

#include "solve/closed_exchange.h"

namespace viewpeel {

// An Irradiation solves (A - X R) H = b for one set of reflectivities and many right sides.
class Irradiation {
 public:
  //   In: closed: kept by reference; reflectivity: r_i in [0, 1], 1 for rows of given heat flux
  Irradiation(const ClosedExchange& closed, const Eigen::VectorXd& reflectivity);

  // Returns the solution H of (A - X R) H = b.
  //   In: b: by row, W    Out: H, by row, W/m2
  //   Error: the residual of S h is below 1e-14 of the sizes of its terms. Tests: tests/unit/solve_heat_test.cpp.
  //   Throws: Error limit where conjugate gradients do not converge.
  //   Cost: some dozens of products of X.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  // Returns the solution to 1e-7 of the right side, for propagating errors. Several threads may call it at once.
  Eigen::VectorXd solveRoughly(const Eigen::VectorXd& b) const;
  // Returns the whole inverse (A - X R)^-1, n x n, in rows.    Cost: 2 n^3; memory 16 n^2 bytes.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inverse() const;
  // Returns S = A - R^(1/2) X R^(1/2), and R^(1/2).
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& symmetric() const { return symmetric_; }
  const Eigen::VectorXd& roots() const { return root_; }
  // Returns the number of steps of conjugate gradients in all calls of solve.
  uint32_t steps() const { return steps_; }

 private:
  Eigen::VectorXd solveSymmetric(const Eigen::VectorXd& right_side) const;
  Eigen::VectorXd irradiationOf(const Eigen::VectorXd& b, const Eigen::VectorXd& h) const;

  const ClosedExchange& closed_;
  Eigen::VectorXd root_;  // square roots of reflectivities
  Eigen::SparseMatrix<double, Eigen::RowMajor> symmetric_;
  mutable uint32_t steps_ = 0;
};

}  // namespace viewpeel
