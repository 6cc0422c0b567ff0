#include "solve/peeled_exchange.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "directions/replicates.h"
#include "directions/sampler.h"
#include "engines/host_engine.h"
#include "engines/lattice.h"
#include <viewpeel/balance.h>
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

using Eigen::VectorXd;

// A square of the median area of polygons has this many spacings to its side. With half as many, errors double while
// the time halves, and answers have a bias; with twice as many, further directions would gain as much (docs/solve.md).
constexpr double kSpacingsPerSide = 2;

}  // namespace

PeeledExchange::PeeledExchange(const Scene& scene, const Ids& ids, const std::optional<PolygonShares>& shares,
                               const MatrixFreeRequest& request, const glm::dvec3& up, Watch watch)
    : scene_(scene), ids_(ids), request_(request), up_(up) {
  options_.resolution =
      request.resolution ? request.resolution : chooseResolution(scene, kSpacingsPerSide, kMaxResolution);
  options_.sampling = chooseSampling(scene, ids, false);
  options_.thread_count = request.threads;
  options_.stop = std::move(watch.stop);
  options_.on_batch = [this, show = std::move(watch.show)](uint64_t done) {
    if (show) show(done, batch_directions_);
  };
  products_ = shares ? std::make_unique<ExchangeProducts>(scene, *shares, options_)
                     : std::make_unique<ExchangeProducts>(scene, ids, options_);
  closed_.areas = Eigen::Map<const VectorXd>(ids.areas.data(), ids.count());
}

std::span<const Direction> PeeledExchange::replicate(uint32_t r) const {
  const size_t count = directions_.size() / kProductReplicateCount;
  return std::span(directions_).subspan(r * count, count);
}

Columns PeeledExchange::multiplyOpen(std::span<const Direction> directions, const Columns& v,
                                     std::vector<ExchangeProducts::Outside>* outside) {
  batch_directions_ = directions.size();
  const auto columns = static_cast<size_t>(v.cols());
  std::vector<double> products = products_->multiply(directions, {v.data(), v.data() + v.size()}, columns, outside);
  sweeps_ += directions.size();
  ++product_count_;
  return Eigen::Map<const Columns>(products.data(), v.rows(), v.cols()) *
         (2 * products_->unitArea() * scene_.scale * scene_.scale / double(directions.size()));
}

void PeeledExchange::requireNoLeak(const std::vector<ExchangeProducts::Outside>& outside) const {
  const double of_count = 2 * products_->unitArea() * scene_.scale * scene_.scale / double(directions_.size());
  double leak = 0, largest = 0;
  size_t row = 0;
  for (size_t i = 0; i < outside.size(); ++i) {
    const double of_row = outside[i].leak * of_count;
    leak += of_row;
    if (of_row > largest) largest = of_row, row = i;
  }
  if (leak > kGrazingShare * closed_.areas.sum()) refuseLeak(leak / closed_.areas.sum(), ids_.names[row], &scene_);
}

void PeeledExchange::draw(uint32_t directions, uint64_t round) {
  directions_.clear();
  for (uint32_t r = 0; r < kProductReplicateCount; ++r) {
    const uint64_t number = kProductReplicates.first + kProductReplicateCount * round + r;
    for (Direction& direction : sampleDirections(Sampler::fibonacci, directions, request_.seed, number)) {
      if (glm::dot(direction.u, up_) < 0) direction.u = -direction.u, direction.x_axis = -direction.x_axis;
      directions_.push_back(direction);
    }
  }
  const Eigen::Index n = closed_.areas.size();
  std::vector<ExchangeProducts::Outside> outside(ids_.count());
  VectorXd with_pairs = VectorXd::Zero(n);
  std::vector<double> leaving;  // exchange area of all rows with the environment, by replicate
  const double of_count = 2 * products_->unitArea() * scene_.scale * scene_.scale / directions;
  double before = 0;
  for (uint32_t r = 0; r < kProductReplicateCount; ++r) {
    with_pairs += multiplyOpen(replicate(r), Columns::Ones(n, 1), &outside).col(0) / kProductReplicateCount;
    double lines = 0;
    for (const ExchangeProducts::Outside& of_row : outside) lines += of_row.ahead + of_row.behind;
    leaving.push_back((lines - before) * of_count);
    before = lines;
  }
  requireNoLeak(outside);
  double mean = 0, squares = 0;
  for (const double of_replicate : leaving) mean += of_replicate / kProductReplicateCount;
  for (const double of_replicate : leaving) squares += std::pow(of_replicate - mean, 2);
  const double error = std::sqrt(squares / (kProductReplicateCount * (kProductReplicateCount - 1.0)));
  const double area = closed_.areas.sum();
  closed_.is_open = mean > kGrazingShare * area && mean > kErrorsOfOpenScene * error;
  closed_.environment_share = closed_.is_open ? mean / area : 0;
  closed_.environment = VectorXd::Zero(n);
  up_share_ = VectorXd::Constant(n, 0.5);
  if (closed_.is_open)
    for (Eigen::Index i = 0; i < n; ++i) {
      const ExchangeProducts::Outside& of_row = outside[static_cast<size_t>(i)];
      const double lines = of_row.ahead + of_row.behind;
      closed_.environment[i] = lines * of_count / kProductReplicateCount;
      if (lines > 0) up_share_[i] = of_row.ahead / lines;
    }
  given_ = with_pairs + closed_.environment;
  closed_.largest_lack = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    // A line between two polygons of one row leaves the row at both of its ends, so that it counts twice.
    const double within = 2 * outside[static_cast<size_t>(i)].within * of_count / kProductReplicateCount;
    const double lack = 1 - (given_[i] + within) / closed_.areas[i];
    if (std::abs(lack) > std::abs(closed_.largest_lack))
      closed_.largest_lack = lack, closed_.lacking_row = static_cast<uint32_t>(i);
  }
}

Columns PeeledExchange::multiply(const Columns& v) {
  Columns products = multiplyOpen(directions_, v, nullptr);
  products.array() += v.array().colwise() * (closed_.areas - given_).array();
  return products;
}

PeeledExchange::Part PeeledExchange::multiplyPart(uint32_t r, const Columns& v) {
  std::vector<ExchangeProducts::Outside> outside(ids_.count());
  Part part{multiplyOpen(replicate(r), v, &outside), VectorXd::Zero(v.rows()), VectorXd::Zero(v.rows())};
  if (!closed_.is_open) return part;
  const double of_count = 2 * products_->unitArea() * scene_.scale * scene_.scale / double(replicate(r).size());
  for (Eigen::Index i = 0; i < v.rows(); ++i) {
    part.up[i] = outside[static_cast<size_t>(i)].ahead * of_count;
    part.down[i] = outside[static_cast<size_t>(i)].behind * of_count;
  }
  return part;
}

VectorXd PeeledExchange::errorOfNextLine(const VectorXd& radiosity, const VectorXd& irradiation,
                                         const VectorXd& outside_power) const {
  const Eigen::Index n = closed_.areas.size();
  const double centre = closed_.areas.dot(radiosity) / closed_.areas.sum();
  std::vector<Eigen::Index> by_area(static_cast<size_t>(n));
  std::iota(by_area.begin(), by_area.end(), 0);
  std::stable_sort(by_area.begin(), by_area.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return closed_.areas[a] > closed_.areas[b]; });
  // These are of the k largest rows, and `most_power` is the largest A |B - centre| of all others, W.
  VectorXd least(n + 1), most(n + 1), most_power(n + 1);
  least[0] = INFINITY, most[0] = -INFINITY, most_power[n] = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double b = radiosity[by_area[size_t(k)]];
    least[k + 1] = std::min(least[k], b), most[k + 1] = std::max(most[k], b);
  }
  for (Eigen::Index k = n; k-- > 0;) {
    const Eigen::Index row = by_area[size_t(k)];
    most_power[k] = std::max(most_power[k + 1], closed_.areas[row] * std::abs(radiosity[row] - centre));
  }
  VectorXd errors(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double area = closed_.areas[i], h = irradiation[i];
    const double lines =
        double(directions_.size()) *
        expectedPoints(options_.sampling, area / std::pow(scene_.scale, 2) / ids_.sides(), 2.0 / options_.resolution);
    const double of_line = area / (lines + 1);
    const auto larger = std::partition_point(by_area.begin(), by_area.end(),
                                             [&](Eigen::Index row) { return closed_.areas[row] >= of_line; }) -
                        by_area.begin();
    double change = larger > 0 ? std::max(most[larger] - h, h - least[larger]) : 0;
    if (closed_.is_open) change = std::max(change, std::abs(outside_power[i] - h));
    // A smaller area A_j changes it by A_j |B_j - H_i|, at most A_j |B_j - centre| + A_j |centre - H_i|.
    const double of_smaller = larger < n ? most_power[larger] / of_line + std::abs(centre - h) : 0;
    errors[i] = std::max(change, of_smaller) * of_line / area;
  }
  return errors;
}

}  // namespace viewpeel
