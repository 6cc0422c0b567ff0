#include "estimator/visibility_bounds.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "unoccluded/unoccluded.h"
#include <viewpeel/error.h>
#include "estimator/guarantee.h"

namespace viewpeel {
namespace {

constexpr double kUnoccludedError =
    kUnoccludedRelativeError + kUnoccludedAbsoluteError;  // of a form factor, which is 1 at most

}  // namespace

double givenVarianceBound(double variance, double range, double directions, double p) {
  const double l = std::log(2 / p), third = range * l / 3;
  return (third + std::sqrt(third * third + 2 * directions * variance * l)) / directions;
}

VisibilityBounds::VisibilityBounds(const Ids& ids, const std::vector<double>& ranges, const Prior& prior)
    : areas_(ids.areas), ranges_(ranges), row_bounds_(ids.count(), 2) {
  pair_count_ = double(pairCount(ids.count()));
  std::vector<uint32_t> polygons(ids.count(), 0);
  for (uint32_t id : ids.of_polygon) ++polygons[id];
  for (uint32_t id = 0; id < ids.count(); ++id) {
    if (polygons[id] > 1) ++row_bounds_[id];  // an id of several polygons may see itself
    row_count_ += row_bounds_[id];
  }
  largest_range_ = *std::max_element(ranges.begin(), ranges.end());
  for (const PairPrior& pair : prior.pairs) {
    if (pair.j >= kEnvironment) continue;
    const uint32_t smaller = ids.areas[pair.j] < ids.areas[pair.i] ? pair.j : pair.i;
    const double b = double(pair.visibility) / kVisibilityOne,
                 most = std::min(1.0, pair.exchange / ids.areas[smaller] * (1 + kUnoccludedRelativeError) +
                                          kUnoccludedAbsoluteError);
    pairs_.push_back({pair.i, pair.j, ranges[smaller], std::pow(std::max(b, 1 - b), 2) * ranges[smaller] * most});
  }
}

uint64_t VisibilityBounds::directionsFor(double epsilon, double delta) const {
  const double e = epsilon - kUnoccludedError;
  if (!(e > 0))
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("unoccluded form factors are good to {:.2g}: ask for a larger --epsilon, or --unoccluded off",
                    kUnoccludedError));
  const auto failure = [&](double n) {
    const auto byVariance = [&](double variance, double range) {
      return 2 * std::exp(-n * e * e * std::max(2 / (range * range), 1 / (2 * variance + 2 * range * e / 3)));
    };
    double sum =
        (pair_count_ - double(pairs_.size())) * byVariance(largest_range_ * kUnoccludedAbsoluteError, largest_range_);
    for (const Pair& pair : pairs_) sum += byVariance(pair.variance, pair.range);
    for (size_t id = 0; id < ranges_.size(); ++id)
      sum += row_bounds_[id] * 2 * std::exp(-2 * n * e * e / (ranges_[id] * ranges_[id]));
    return sum;
  };
  return leastDirections(failure, delta, epsilon, largest_range_);
}

VisibilityBounds::Variances VisibilityBounds::measureVariances(const ControlVariateSums& sums,
                                                               double measure_area) const {
  Variances variances{std::vector<double>(pairs_.size(), 0), std::vector<double>(areas_.size(), 0)};
  size_t at = 0;
  sums.forEachVariance(measure_area, [&](uint32_t i, uint32_t j, double variance) {
    if (j >= kEnvironment || i == j) {
      double& largest = variances.of_rows[i];
      largest = std::max(largest, variance / (areas_[i] * areas_[i]));
      return;
    }
    while (at < pairs_.size() && std::pair(pairs_[at].i, pairs_[at].j) < std::pair(i, j)) ++at;
    if (at < pairs_.size() && pairs_[at].i == i && pairs_[at].j == j)
      variances.of_pairs[at] = variance / std::pow(std::min(areas_[i], areas_[j]), 2);
  });
  return variances;
}

double VisibilityBounds::largestBound(const Variances& variances, double blocks, double block_directions,
                                      double p) const {
  const double p_pair = p / 2 / pair_count_, p_row = p / 2 / row_count_, directions = blocks * block_directions;
  double largest = givenVarianceBound(largest_range_ * kUnoccludedAbsoluteError, largest_range_, directions,
                                      p_pair);  // pairs that do not see each other
  for (size_t k = 0; k < pairs_.size(); ++k) {
    const double prior = givenVarianceBound(pairs_[k].variance, pairs_[k].range, directions, p_pair);
    const bool is_prior_best = prior <= bernsteinBound(0, pairs_[k].range, blocks, p_pair);
    largest = std::max(largest,
                       is_prior_best ? prior : bernsteinBound(variances.of_pairs[k], pairs_[k].range, blocks, p_pair));
  }
  for (size_t id = 0; id < ranges_.size(); ++id)
    largest = std::max(largest, bernsteinBound(variances.of_rows[id], ranges_[id], blocks, p_row));
  return largest + kUnoccludedError;
}

Prior keepBounded(Prior prior, const Ids& ids, bool has_one_lattice) {
  std::vector<uint32_t> polygons(ids.count(), 0);
  for (uint32_t id : ids.of_polygon) ++polygons[id];
  for (PairPrior& pair : prior.pairs) {
    const bool keeps = pair.j >= kEnvironment ? has_one_lattice : polygons[pair.i] == 1 && polygons[pair.j] == 1;
    if (!keeps) pair.visibility = pair.surface_visibility = 0;
  }
  return prior;
}

}  // namespace viewpeel
