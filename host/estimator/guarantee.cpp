#include "estimator/guarantee.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/bounds.h"

namespace viewpeel {
namespace {

constexpr double kCountableDirections = 1e15;  // below 2^53, so that double holds every number of directions exactly

}  // namespace

std::vector<double> formFactorRanges(const Scene& scene, const Ids& ids, const std::vector<double>& resolutions,
                                     Sampling sampling) {
  const auto rangeOn = [&](uint32_t k, double resolution) {
    const ConvexSize size = sizeOf(scene, scene.polygons[k]);
    const double h = resolutions.empty() ? 0 : 2 / resolution;
    return (sampling == Sampling::scanline ? scanlineRange(size, h) : latticeRange(size, h)) * ids.sides();
  };
  std::vector<double> ranges(ids.count(), 0), coarsest(ids.count(), INFINITY), finest(ids.count(), 0);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t id = ids.of_polygon[k];
    const double resolution = resolutions.empty() ? 1 : resolutions[k];
    ranges[id] += rangeOn(k, resolution);
    coarsest[id] = std::min(coarsest[id], resolution);
    finest[id] = std::max(finest[id], resolution);
  }
  // Ids of several resolutions have a range on each of their lattices, which is kept by resolution and id.
  std::map<double, std::map<uint32_t, double>> mixed;
  for (uint32_t k = 0; k < scene.polygons.size(); ++k)
    if (const uint32_t id = ids.of_polygon[k]; coarsest[id] < finest[id])
      mixed[resolutions[k]][id] += rangeOn(k, resolutions[k]);
  for (const auto& [resolution, range_of] : mixed) {
    const double most = std::max_element(range_of.begin(), range_of.end(), [](const auto& a, const auto& b) {
                          return a.second < b.second;
                        })->second;
    std::vector<double> once_more(ids.count(), 0);
    for (uint32_t k = 0; k < scene.polygons.size(); ++k)
      if (resolutions[k] < resolution) once_more[ids.of_polygon[k]] += rangeOn(k, resolution);
    for (uint32_t id = 0; id < ids.count(); ++id) ranges[id] += std::min(once_more[id], most);
  }
  for (uint32_t id = 0; id < ids.count(); ++id) ranges[id] *= scene.scale * scene.scale / ids.areas[id];
  return ranges;
}

std::vector<double> countBounds(const Ids& ids) {
  std::vector<uint32_t> order(ids.count()), polygons(ids.count(), 0);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return ids.areas[a] < ids.areas[b]; });
  for (uint32_t id : ids.of_polygon) ++polygons[id];
  std::vector<double> bounds(ids.count());
  for (size_t k = 0; k < order.size(); ++k)
    bounds[order[k]] = double(order.size() - 1 - k) + 2 + (polygons[order[k]] > 1 ? 1 : 0);
  return bounds;
}

uint64_t hoeffdingDirections(const std::vector<double>& ranges, const std::vector<double>& bounds, double epsilon,
                             double delta) {
  const auto failure = [&](double n) {
    double sum = 0;
    for (size_t k = 0; k < ranges.size(); ++k)
      sum += bounds[k] * 2 * std::exp(-2 * n * epsilon * epsilon / (ranges[k] * ranges[k]));
    return sum;
  };
  return leastDirections(failure, delta, epsilon, *std::max_element(ranges.begin(), ranges.end()));
}

uint64_t leastDirections(const std::function<double(double)>& failure, double delta, double epsilon, double range) {
  if (!(failure(kCountableDirections) <= delta))
    throw Error(
        ErrorCode::bad_usage,
        fmt::format("a guarantee of {} takes more than {:.0e} directions, each of which adds up to {:.3g} to a form "
                    "factor (2 unless polygons are far smaller than "
                    "the scene); ask for a larger --epsilon, or an estimate by --tolerance",
                    epsilon, kCountableDirections, range));
  double low = 0, high = 1;
  while (failure(high) > delta) high *= 2;
  while (high - low > 1) (failure(std::floor((low + high) / 2)) > delta ? low : high) = std::floor((low + high) / 2);
  return static_cast<uint64_t>(high);
}

double bernsteinBound(double variance, double range, double blocks, double p) {
  const double l = std::log(4 / p);
  return std::sqrt(2 * variance * l / blocks) + 7 * range * l / (3 * (blocks - 1));
}

}  // namespace viewpeel
