// Balanced exchange areas have one multiplier y_i for each row. The multipliers minimise phi of docs/method.md, eq.
// (34), with x_ij(y) of its section 10. (For i = j, y_i stands in place of y_i + y_j.)
//
// Newton's method uses the Hessian of the piece of phi at the current point. It may be singular, as for two plates that
// see only each other, so it is regularised by the current error. Conjugate gradients solve it to this error, and
// Armijo's rule chooses the step. This is the dual Newton method of H. Qi & D. Sun, A quadratically convergent Newton
// method for computing the nearest correlation matrix, SIAM J. Matrix Anal. Appl. 28(2), 2006, 360-385, for rows in
// place of a diagonal.
#include <viewpeel/balance.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;
using Entry = FormFactors::Entry;

constexpr uint32_t kMostSteps = 200, kMostHalvings = 50;

struct Point {
  VectorXd y;
  std::vector<double> x;  // by entry; environment and leak stay 0
  VectorXd residual;      // row sums of x, less the areas: the gradient of phi
};

double weightOf(const Entry& entry) {
  const auto& [value, error] = entry.exchange_area;
  return entry.j >= kEnvironment ? 0 : error > 0 ? std::min(error, value) : value;
}

class Dual {
 public:
  explicit Dual(const FormFactors& measured)
      : entries_(measured.entries()),
        ids_(measured.ids()),
        areas_(Eigen::Map<const VectorXd>(ids_.areas.data(), ids_.count())),
        row_weights_(VectorXd::Zero(ids_.count())),
        hessian_(ids_.count(), ids_.count()) {
    for (const Entry& entry : entries_) {
      weights_.push_back(weightOf(entry));
      addToRows(row_weights_, entry, weights_.back());
    }
    refuseEmptyRows();
    makePattern();
  }

  Point start() const { return evaluate(VectorXd::Zero(areas_.size())); }
  double errorOf(const Point& at) const { return at.residual.cwiseQuotient(areas_).cwiseAbs().maxCoeff(); }

  void step(Point& at) {
    refuseImpossible(at.y);
    const VectorXd direction = findDirection(at, std::min(0.1, errorOf(at)));
    const double slope = at.residual.dot(direction);
    Point next = evaluate(at.y + direction);
    double length = 1;
    for (uint32_t k = 0; k < kMostHalvings && !decreases(at, next, direction, length, slope); ++k) {
      length /= 2;
      next = evaluate(at.y + length * direction);
    }
    at = std::move(next);
  }

 private:
  static double sumOfRows(const VectorXd& y, const Entry& pair) {
    return pair.i == pair.j ? y[pair.i] : y[pair.i] + y[pair.j];
  }
  static void addToRows(VectorXd& rows, const Entry& entry, double value) {
    if (entry.j >= kEnvironment) return;
    rows[entry.i] += value;
    if (entry.i != entry.j) rows[entry.j] += value;
  }

  void refuseEmptyRows() const {
    for (uint32_t i = 0; i < ids_.count(); ++i)
      if (row_weights_[i] == 0)
        throw Error(
            ErrorCode::bad_input,
            fmt::format(
                "balance: no line from '{}' to any polygon was counted; use more --directions or a finer --resolution",
                ids_.names[i]));
  }

  Point evaluate(VectorXd y) const {
    Point at{std::move(y), std::vector<double>(entries_.size()), -areas_};
    for (size_t k = 0; k < entries_.size(); ++k) {
      if (weights_[k] == 0) continue;
      at.x[k] = std::max(0.0, entries_[k].exchange_area.value + weights_[k] * sumOfRows(at.y, entries_[k]));
      addToRows(at.residual, entries_[k], at.x[k]);
    }
    return at;
  }

  // Returns whether the step satisfies Armijo's rule. The change of phi is summed term by term from the step itself,
  // for near the minimum it is far below the rounding of phi.
  bool decreases(const Point& at, const Point& next, const VectorXd& direction, double length, double slope) const {
    double change = 0, size = 0;
    const auto add = [&](double term) {
      change += term;
      size += std::abs(term);
    };
    for (size_t k = 0; k < entries_.size(); ++k) {
      if (weights_[k] == 0) continue;
      const double moved = at.x[k] > 0 && next.x[k] > 0 ? length * sumOfRows(direction, entries_[k])
                                                        : (next.x[k] - at.x[k]) / weights_[k];
      add(moved * (next.x[k] + at.x[k]) / 2);
    }
    for (Eigen::Index i = 0; i < areas_.size(); ++i) add(-areas_[i] * length * direction[i]);
    constexpr double kShare = 1e-4, kRounding = 1e-13;
    return change <= kShare * length * slope + kRounding * size;
  }

  // Reserves the diagonal and the pairs of the upper triangle, in the order in which findDirection() fills in values.
  void makePattern() {
    hessian_.reserve(static_cast<Eigen::Index>(entries_.size()) + ids_.count());
    auto entry = entries_.begin();
    for (uint32_t i = 0; i < ids_.count(); ++i) {
      hessian_.startVec(i);
      hessian_.insertBack(i, i) = 0;
      for (; entry != entries_.end() && entry->i == i; ++entry)
        if (entry->j < kEnvironment && entry->j != i) hessian_.insertBack(i, entry->j) = 0;
    }
    hessian_.finalize();
  }

  // Solves (H + inexactness D) d = -residual, where D has the row sums of w on its diagonal. Entries of H are w_ij
  // where x_ij > 0. Variables are scaled by D^(1/2).
  VectorXd findDirection(const Point& at, double inexactness) {
    VectorXd diagonal = inexactness * row_weights_;
    for (size_t k = 0; k < entries_.size(); ++k)
      if (at.x[k] > 0) addToRows(diagonal, entries_[k], weights_[k]);
    const VectorXd scale = row_weights_.cwiseSqrt().cwiseInverse();
    double* value = hessian_.valuePtr();
    size_t k = 0;
    for (uint32_t i = 0; i < ids_.count(); ++i) {
      *value++ = diagonal[i] * scale[i] * scale[i];
      for (; k < entries_.size() && entries_[k].i == i; ++k)
        if (entries_[k].j < kEnvironment && entries_[k].j != i)
          *value++ = at.x[k] > 0 ? weights_[k] * scale[i] * scale[entries_[k].j] : 0;
    }
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Upper> solver(hessian_);
    solver.setTolerance(std::max(1e-6, inexactness));
    const VectorXd right_side = -scale.cwiseProduct(at.residual);
    return scale.cwiseProduct(solver.solve(right_side));
  }

  // Throws the Error that names rows which no x can balance. No x exists if and only if some set of rows is larger in
  // area than all its partners. Then y grows without bound along a direction d with d_i + d_j <= 0 for every pair. The
  // rows with y above some threshold are then such a set.
  void refuseImpossible(const VectorXd& y) const {
    const uint32_t n = ids_.count();
    std::vector<uint32_t> rows(n), rank(n), joins(n, n);
    std::iota(rows.begin(), rows.end(), 0u);
    std::sort(rows.begin(), rows.end(), [&](uint32_t a, uint32_t b) { return y[a] > y[b]; });
    for (uint32_t k = 0; k < n; ++k) rank[rows[k]] = k;
    for (size_t k = 0; k < entries_.size(); ++k) {
      if (weights_[k] == 0) continue;
      const Entry& entry = entries_[k];
      joins[entry.i] = std::min(joins[entry.i], rank[entry.j]);
      joins[entry.j] = std::min(joins[entry.j], rank[entry.i]);
    }
    std::vector<double> joining_area(n, 0.0);
    for (uint32_t i = 0; i < n; ++i) joining_area[joins[i]] += areas_[i];
    double area = 0, reachable_area = 0;
    for (uint32_t k = 0; k < n; ++k) {
      area += areas_[rows[k]];
      reachable_area += joining_area[k];
      if (area > reachable_area * (1 + 2 * kBalanceTolerance))
        throw Error(
            ErrorCode::bad_input,
            fmt::format(
                "balance: lines from '{}'{} of area {:.6g} hit only rows of area {:.6g}; use more --directions or "
                "a finer --resolution",
                ids_.names[rows[0]], k ? fmt::format(" and {} more rows", k) : "", area, reachable_area));
    }
  }

  const std::vector<Entry>& entries_;
  const Ids& ids_;
  VectorXd areas_;
  std::vector<double> weights_;  // w by entry
  VectorXd row_weights_;         // sums of w over each row
  Eigen::SparseMatrix<double, Eigen::RowMajor> hessian_;
};

void refuseOpen(const FormFactors& measured) {
  double environment = 0, leak = 0;
  for (const Entry& entry : measured.entries()) {
    if (entry.j == kEnvironment) environment += entry.exchange_area.value;
    if (entry.j == kLeak) leak += entry.exchange_area.value;
  }
  const std::vector<double>& areas = measured.ids().areas;
  const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
  if (environment + leak > kGrazingShare * area)
    throw Error(ErrorCode::bad_input, fmt::format("balance: {:.3g} % of all emitted radiation leaves the scene and "
                                                  "{:.3g} % ends on backs; close the scene, turn flipped "
                                                  "polygons, or leave --balance out",
                                                  100 * environment / area, 100 * leak / area));
}

void measureChanges(const FormFactors& measured, BalancedFormFactors& balanced) {
  double changes = 0, variances = 0;
  for (size_t k = 0; k < measured.entries().size(); ++k) {
    const Entry& entry = measured.entries()[k];
    if (entry.j >= kEnvironment) continue;
    const double change = std::abs(balanced.form_factors.entries()[k].exchange_area.value - entry.exchange_area.value);
    const double standard_error = entry.exchange_area.standard_error;
    changes += change * change;
    variances += standard_error * standard_error;
    if (standard_error > 0) balanced.largest_change = std::max(balanced.largest_change, change / standard_error);
    const std::vector<double>& areas = measured.ids().areas;
    const auto [from, to] =
        areas[entry.i] <= areas[entry.j] ? std::pair(entry.i, entry.j) : std::pair(entry.j, entry.i);
    if (change / areas[from] >= balanced.largest_form_factor_change) {
      balanced.largest_form_factor_change = change / areas[from];
      balanced.from = from;
      balanced.to = to;
    }
  }
  if (variances > 0) balanced.rms_change = std::sqrt(changes / variances);
}

}  // namespace

BalancedFormFactors balanceRows(const FormFactors& measured) {
  const Ids& ids = measured.ids();
  if (!ids.requested.empty()) throw Error(ErrorCode::bad_usage, kBalanceNeedsEveryRow);
  refuseOpen(measured);

  Dual dual(measured);
  Point at = dual.start();
  uint32_t steps = 0;
  for (; dual.errorOf(at) > kBalanceTolerance; ++steps) {
    if (steps == kMostSteps)
      throw Error(ErrorCode::limit, fmt::format("balance: row sums still differ from 1 by {:.1e} after {} steps; use "
                                                "more --directions or a finer --resolution",
                                                dual.errorOf(at), steps));
    dual.step(at);
  }

  std::vector<Entry> entries = measured.entries();
  for (size_t k = 0; k < entries.size(); ++k) entries[k].exchange_area.value = at.x[k];
  std::vector<Measured> row_sums(ids.count());
  for (uint32_t i = 0; i < ids.count(); ++i) row_sums[i].value = 1 + at.residual[i] / ids.areas[i];
  BalancedFormFactors balanced{
      FormFactors(ids, std::move(entries), std::move(row_sums)), {at.y.begin(), at.y.end()}, steps};
  measureChanges(measured, balanced);
  return balanced;
}

}  // namespace viewpeel
