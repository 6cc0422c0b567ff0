// ExchangeMatrix holds A_i F_ij of all pairs of polygons. errorOf() measures the difference of two such matrices.
#pragma once
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/ids.h>

namespace viewpeel::bench {

// ExchangeMatrix is symmetric, with zeros on the diagonal, and stored densely as n (n - 1) / 2 doubles.
class ExchangeMatrix {
 public:
  explicit ExchangeMatrix(uint32_t count = 0) : count_(count), values_(pairCount(count)) {}

  uint32_t count() const { return count_; }
  // Returns the exchange area of a pair.    In: i != j
  double& at(uint32_t i, uint32_t j) { return values_[index(i, j)]; }
  double at(uint32_t i, uint32_t j) const { return values_[index(i, j)]; }
  std::vector<double>& values() { return values_; }
  const std::vector<double>& values() const { return values_; }

 private:
  uint64_t index(uint32_t i, uint32_t j) const {
    if (i > j) std::swap(i, j);
    return uint64_t(i) * (2 * uint64_t(count_) - i - 1) / 2 + (j - i - 1);
  }
  uint32_t count_;
  std::vector<double> values_;
};

// MatrixError is the error e of form factors over all ordered pairs i != j. The weighted errors give each pair the
// weight w_ij = C_ij = A_i F_ij / 2 that it has in the exchange of radiation. Then rms = sqrt(sum w e^2 / sum w), and
// largest = max sqrt(w / max w) |e|.
struct MatrixError {
  double rms = 0, largest = 0, weighted_rms = 0, weighted_largest = 0;
};

class ErrorSums {
 public:
  // Adds the errors of F_ij and of F_ji.    In: exchange area of the reference, error of the exchange area,
  // areas of both polygons
  void add(double reference, double error, double area_i, double area_j) {
    const double e_i = error / area_i, e_j = error / area_j, largest = std::fmax(std::abs(e_i), std::abs(e_j));
    squares_ += e_i * e_i + e_j * e_j;
    weighted_squares_ += reference * (e_i * e_i + e_j * e_j);
    weights_ += 2 * reference;
    most_weight_ = std::fmax(most_weight_, reference);
    largest_ = std::fmax(largest_, largest);
    weighted_largest_ = std::fmax(weighted_largest_, std::sqrt(reference) * largest);
  }
  MatrixError over(uint32_t count) const {
    const double pairs = double(count) * (count - 1.0);
    return {std::sqrt(squares_ / pairs), largest_, weights_ > 0 ? std::sqrt(weighted_squares_ / weights_) : 0,
            most_weight_ > 0 ? weighted_largest_ / std::sqrt(most_weight_) : 0};
  }

 private:
  double squares_ = 0, weighted_squares_ = 0, weights_ = 0, most_weight_ = 0, largest_ = 0, weighted_largest_ = 0;
};

// Returns the error of a matrix.    In: matrices of the same polygons; areas in the unit of both
inline MatrixError errorOf(const ExchangeMatrix& measured, const ExchangeMatrix& reference,
                           const std::vector<double>& areas) {
  ErrorSums sums;
  for (uint32_t i = 0; i < measured.count(); ++i)
    for (uint32_t j = i + 1; j < measured.count(); ++j)
      sums.add(reference.at(i, j), measured.at(i, j) - reference.at(i, j), areas[i], areas[j]);
  return sums.over(measured.count());
}

// Returns for each row the exchange area with environment and leak: the polygon's area less its exchange areas.
inline std::vector<double> restOf(const ExchangeMatrix& exchange, const std::vector<double>& areas) {
  std::vector<double> rest = areas;
  for (uint32_t i = 0; i < exchange.count(); ++i)
    for (uint32_t j = i + 1; j < exchange.count(); ++j) rest[i] -= exchange.at(i, j), rest[j] -= exchange.at(i, j);
  return rest;
}

// RestError is the rms and largest error of restOf(), as form factors.
struct RestError {
  double rms = 0, largest = 0;
};

inline RestError errorOfRest(const std::vector<double>& measured, const std::vector<double>& reference,
                             const std::vector<double>& areas) {
  RestError error;
  for (size_t i = 0; i < areas.size(); ++i) {
    const double e = (measured[i] - reference[i]) / areas[i];
    error.rms += e * e / double(areas.size());
    error.largest = std::fmax(error.largest, std::abs(e));
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

}  // namespace viewpeel::bench
