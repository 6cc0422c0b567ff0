// BandErrors have the errors of solutions with bands of wavelengths, in first order.
#pragma once
#include <cmath>
#include <vector>

#include "solve/band_state.h"

namespace viewpeel {

// A BandDisturbance is the effect of an error of exchange areas. of_bands is the effect on A H_k of each band k, W,
// where A are areas and H_k irradiations. The other two are effects on each row's exchange area with the whole
// environment, and with its part above the horizon (up).
struct BandDisturbance {
  BandVectors of_bands;
  Eigen::VectorXd environment, up;

  BandDisturbance(Eigen::Index rows, size_t bands)
      : of_bands(bands, Eigen::VectorXd::Zero(rows)),
        environment(Eigen::VectorXd::Zero(rows)),
        up(Eigen::VectorXd::Zero(rows)) {}
};

// A BandResponse says how temperatures, K, and irradiations, W/m2, change under a disturbance, in first order.
struct BandResponse {
  Eigen::VectorXd temperature;
  BandVectors irradiation;
};

// BandErrors have a column for each of several independent errors: how it changes all answers. Beside these, each row
// may have an error that no other row shares.
class BandErrors {
 public:
  //   In: closed: its pairs are not read; both: referred to; columns: number of errors; weighted: number of the first
  //     columns whose squares have the factor `weight`, the others have 1
  BandErrors(const ClosedExchange& closed, const BandState& state, size_t columns, size_t weighted, double weight);

  // Sets a column. Several threads may set different columns at once.
  void put(size_t column, const BandDisturbance& disturbance, const BandResponse& response);
  // Sets errors of single rows. Each is independent of all others, and is left out of the flow to the environment.
  //   In: response: of each row to its error
  void putOfRows(const BandResponse& response);

  // An Answer is a quantity that has a value for each row of the solution.
  enum Answer { kTemperature, kEmission, kRadiosity, kIrradiation, kFlux };
  struct Term {
    uint32_t row;
    double factor;
  };
  // Returns the standard error of sum_k factor_k answer_k.    Cost: O(columns x terms).
  double standardError(Answer answer, const std::vector<Term>& terms) const;
  // Returns the standard error of the heat flow to the environment, and to its parts above and below the horizon.
  double toEnvironment() const { return std::sqrt(weighedSquares(to_up_ + to_down_)); }
  double toUp() const { return std::sqrt(weighedSquares(to_up_)); }
  double toDown() const { return std::sqrt(weighedSquares(to_down_)); }

 private:
  using Changes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<Eigen::VectorXd> changesOf(const BandResponse& response) const;
  double weighedSquares(const Eigen::VectorXd& changes) const;

  const ClosedExchange& closed_;
  const BandState& state_;
  Eigen::Index weighted_;
  double weight_;
  BandVectors radiosities_;
  std::vector<Changes> changes_;          // by Answer: rows x columns
  std::vector<Eigen::VectorXd> of_rows_;  // by Answer: errors of single rows
  Eigen::VectorXd to_up_, to_down_;       // by column
};

}  // namespace viewpeel
