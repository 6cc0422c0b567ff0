#include "solve/irradiation.h"

#include <Eigen/IterativeLinearSolvers>
#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;
using Solver = Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper>;
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kResidual = 1e-14, kStep = 1e-10, kRoughStep = 1e-7;
constexpr int kRefinements = 4;

}  // namespace

Irradiation::Irradiation(const ClosedExchange& closed, const VectorXd& reflectivity)
    : closed_(closed), root_(reflectivity.cwiseSqrt()), symmetric_(closed.pairs) {
  for (Eigen::Index i = 0; i < symmetric_.outerSize(); ++i)
    for (decltype(symmetric_)::InnerIterator at(symmetric_, i); at; ++at)
      at.valueRef() = (at.col() == i ? closed_.areas[i] : 0) - root_[i] * at.value() * root_[at.col()];
}

VectorXd Irradiation::solveSymmetric(const VectorXd& right_side) const {
  VectorXd h = VectorXd::Zero(right_side.size()), residual = right_side;
  if (!(right_side.norm() > 0)) return h;
  const VectorXd diagonal = symmetric_.diagonal();
  // The residual may be up to kResidual of the sum of all terms' sizes. Entries of S off the diagonal are below 0.
  const auto sizeOfTerms = [&] {
    const VectorXd sizes = h.cwiseAbs();
    return (right_side.cwiseAbs() + 2 * diagonal.cwiseProduct(sizes) - symmetric_ * sizes).norm();
  };
  Solver solver(symmetric_);
  solver.setTolerance(kStep);
  solver.setMaxIterations(10 * right_side.size() + 1000);
  // Rounding limits one run of conjugate gradients, so a next run starts from the true residual.
  for (int turn = 0; turn < kRefinements; ++turn) {
    h += solver.solve(residual);
    steps_ += static_cast<uint32_t>(solver.iterations());
    residual = right_side - symmetric_ * h;
    if (residual.norm() <= kResidual * sizeOfTerms()) return h;
  }
  throw Error(
      ErrorCode::limit,
      fmt::format("conjugate gradients ended with a relative residual of {:.1e}; emissivities are too small, or "
                  "rows see too little; give larger emissivities, or leave these rows out",
                  residual.norm() / right_side.norm()));
}

VectorXd Irradiation::solve(const VectorXd& b) const { return irradiationOf(b, solveSymmetric(root_.cwiseProduct(b))); }

VectorXd Irradiation::solveRoughly(const VectorXd& b) const {
  Solver solver(symmetric_);
  solver.setTolerance(kRoughStep);
  return irradiationOf(b, solver.solve(root_.cwiseProduct(b)));
}

VectorXd Irradiation::irradiationOf(const VectorXd& b, const VectorXd& h) const {
  return (b + closed_.pairs * root_.cwiseProduct(h)).cwiseQuotient(closed_.areas);
}

RowMajorMatrix Irradiation::inverse() const {
  // The inverse is A^-1 + A^-1 X R^(1/2) S^-1 R^(1/2). This form never divides by R, which may be 0.
  const Eigen::MatrixXd dense = symmetric_;
  RowMajorMatrix inverse = dense.llt().solve(Eigen::MatrixXd(root_.asDiagonal()));
  inverse = root_.asDiagonal() * inverse;
  inverse = closed_.pairs * inverse;
  inverse.diagonal().array() += 1;
  return closed_.areas.cwiseInverse().asDiagonal() * inverse;
}

}  // namespace viewpeel
