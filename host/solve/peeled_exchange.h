// A PeeledExchange multiplies the exchange areas of a scene by vectors, without a matrix: each product peels the same
// directions again. Derivation: docs/solve.md, eq. (14).
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "engines/exchange_products.h"
#include "solve/closed_exchange.h"
#include <viewpeel/matrix_free.h>

namespace viewpeel {

constexpr uint32_t kProductReplicateCount = 8;

// Columns are vectors over rows that are multiplied at once.
using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class PeeledExchange {
 public:
  // A Watch is called while directions are peeled; an exception from it ends the call.
  struct Watch {
    std::function<void()> stop;                             // before each direction, from any thread
    std::function<void(uint64_t done, uint64_t all)> show;  // after some directions of a product
  };

  //   In: scene, ids, request: referred to; shares: where polygons' lines are shared between rows, which ids have; up:
  //     the horizon is orthogonal to it
  PeeledExchange(const Scene& scene, const Ids& ids, const std::optional<PolygonShares>& shares,
                 const MatrixFreeRequest& request, const glm::dvec3& up, Watch watch);

  // Draws the directions of a round, and counts what each row sees.
  //   In: directions: of each replicate; round: from 0
  //   Throws: Error bad_input where more than kGrazingShare of all radiation ends on backs.
  void draw(uint32_t directions, uint64_t round);

  // Returns areas, environment and lack of all rows; its matrix of pairs is empty.
  const ClosedExchange& closed() const { return closed_; }
  // Returns the share of the part above the horizon in each row's exchange with the environment; 1/2 where a row has no
  // such exchange.
  const Eigen::VectorXd& upShare() const { return up_share_; }
  // Returns what each row exchanges with all others and the environment: A_i - x_ii, input units squared.
  const Eigen::VectorXd& given() const { return given_; }

  // Returns X v for each column v, where X holds all exchange areas, and the lack of rows on its diagonal:
  // docs/solve.md, eq. (3).
  //   Error: as ExchangeProducts::multiply.    Cost: one sweep of all directions.
  Columns multiply(const Columns& v);

  // A Part is the exchange of one replicate alone, without the diagonal that closes rows.
  struct Part {
    Columns products;          // sum_j x_ij v_j
    Eigen::VectorXd up, down;  // exchange with the parts of the environment; 0 in a closed scene
  };
  Part multiplyPart(uint32_t replicate, const Columns& v);

  // Returns the error of each row's irradiation that the spread of replicates cannot show, W/m2. Replicates may all
  // miss what a small hot surface sends a row. So one line more is taken to end where irradiation changes most. It has
  // 1 / (n + 1) of a row that n lines are expected to meet. To a row it gives no more than the area it ends on sends.
  //   In: radiosity, irradiation: by row; outside_power: emissive power of the environment that each row sees, by row;
  //     all in W/m2
  Eigen::VectorXd errorOfNextLine(const Eigen::VectorXd& radiosity, const Eigen::VectorXd& irradiation,
                                  const Eigen::VectorXd& outside_power) const;

  ExchangeProducts& products() { return *products_; }
  const LatticeOptions& lattice() const { return options_; }
  uint64_t directionCount() const { return directions_.size(); }
  uint64_t productCount() const { return product_count_; }
  uint64_t sweeps() const { return sweeps_; }
  int resolution() const { return options_.resolution; }
  uint64_t memoryBytes() const { return products_->memoryBytes(); }

 private:
  void requireNoLeak(const std::vector<ExchangeProducts::Outside>& outside) const;
  Columns multiplyOpen(std::span<const Direction> directions, const Columns& v,
                       std::vector<ExchangeProducts::Outside>* outside);
  std::span<const Direction> replicate(uint32_t r) const;

  const Scene& scene_;
  const Ids& ids_;
  const MatrixFreeRequest& request_;
  glm::dvec3 up_;
  LatticeOptions options_;
  std::unique_ptr<ExchangeProducts> products_;
  std::vector<Direction> directions_;  // of all replicates, one after another
  ClosedExchange closed_;
  Eigen::VectorXd up_share_, given_;
  uint64_t sweeps_ = 0, product_count_ = 0, batch_directions_ = 0;
};

}  // namespace viewpeel
