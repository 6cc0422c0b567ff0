#include "estimator/guarantee.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "engines/pair_counters.h"
#include "error.h"
#include "estimator/bounds.h"

namespace viewpeel {
namespace {

constexpr double kFinestResolution = 1 << 14;  // corners keep 10 bits after the point
constexpr double kBaseShare = 0.9;             // of the area, that the first group's resolution is fine enough for
constexpr double kEpochGrowth = 1.15;          // of the blocks from one look at Bernstein's bound to the next
constexpr uint64_t kPilot = uint64_t(1) << 40; // replicate numbers that no run reaches
constexpr uint32_t kPilotBlocks = 24, kPilotDirections = 8;
constexpr std::array kRanges = {5.0, 3.5, 2.8, 2.4, 2.2};  // that lattices are tried for
constexpr uint64_t kFewestBlocks = 8;          // for standard errors
constexpr double kMostDirections = 1e15;       // of a guarantee; beyond 2^53 doubles do not count
constexpr uint64_t kMostAtOnce = 1 << 16;      // directions held at a time

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double diameterOf(const Scene& scene, const Polygon& polygon) {
  double diameter = 0;
  for (uint32_t a = 0; a < polygon.corner_count; ++a)
    for (uint32_t b = 0; b < a; ++b) diameter = std::max(diameter, glm::length(scene.corners[polygon.first_corner + a] - scene.corners[polygon.first_corner + b]));
  return diameter;
}

ConvexSize sizeOf(const Scene& scene, const Polygon& polygon) {
  ConvexSize size{polygon.area, 0, diameterOf(scene, polygon)};
  for (uint32_t c = 0; c < polygon.corner_count; ++c)
    size.perimeter += glm::length(scene.corners[polygon.first_corner + (c + 1) % polygon.corner_count] - scene.corners[polygon.first_corner + c]);
  return size;
}

// Resolutions at which the ranges of ids are at most `range`, as far as they are not too fine.
std::vector<double> neededFor(const Scene& scene, const Ids& ids, double range, Sampling sampling) {
  // sum 2 A + (p or 2 d) h + 2 h^2 = range A has one positive root h.
  std::vector<double> areas(ids.count(), 0), slopes(ids.count(), 0), numbers(ids.count(), 0);
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const ConvexSize size = sizeOf(scene, scene.polygons[k]);
    const uint32_t id = ids.of_polygon[k];
    areas[id] += size.area;
    slopes[id] += sampling == Sampling::scanline ? 2.01 * size.diameter : size.perimeter;
    numbers[id] += 2;
  }
  std::vector<double> needed;
  for (uint32_t id : ids.of_polygon) {
    const double c = (range - 2) * areas[id], h = 2 * c / (slopes[id] + std::sqrt(slopes[id] * slopes[id] + 4 * numbers[id] * c));
    needed.push_back(std::min(2 / h, kFinestResolution));
  }
  return needed;
}

std::vector<double> resolutionsOf(const Scene& scene, const std::vector<SizeGroup>& groups) {
  std::vector<double> resolutions(scene.polygons.size(), 0);
  for (const SizeGroup& group : groups)
    for (uint32_t k : group.polygons) resolutions[k] = group.resolution;
  return resolutions;
}

// Lattices for that range: one for most of the area, windows for what needs more.
std::vector<SizeGroup> groupsFor(const Scene& scene, const std::vector<double>& needed, const Lattices& lattices) {
  if (lattices.resolution) return groupBySize(scene, std::vector<double>(needed.size(), 1), lattices.resolution);
  const double most = *std::max_element(needed.begin(), needed.end());
  if (!lattices.may_group) return groupBySize(scene, std::vector<double>(needed.size(), 1), static_cast<int>(std::min<double>(std::ceil(most), kMaxResolution)));
  std::vector<uint32_t> order(needed.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return needed[a] < needed[b]; });
  double all = 0, area = 0;
  for (const Polygon& polygon : scene.polygons) all += polygon.area;
  double base = most;
  for (uint32_t k : order) {
    area += scene.polygons[k].area;
    if (area < kBaseShare * all) continue;
    base = needed[k];
    break;
  }
  return groupBySize(scene, needed, static_cast<int>(std::min<double>(std::ceil(base), kMaxResolution)));
}

// The area of the smaller of a pair's ids, in which a form factor is largest.
double smallerArea(const Ids& ids, uint32_t i, uint32_t j) { return j < kEnvironment ? std::min(ids.areas[i], ids.areas[j]) : ids.areas[i]; }

// The most that sums of blocks are off by, with Bernstein's inequality, over all ids and pairs.
double largestBernsteinBound(const ReplicateSums& sums, const Ids& ids, const std::vector<double>& ranges, double measure_area, double p) {
  const auto blocks = double(sums.replicateCount());
  double largest = bernsteinBound(0, *std::max_element(ranges.begin(), ranges.end()), blocks, p);  // what was never met
  sums.forEachPair(measure_area, [&](uint32_t i, uint32_t j, const Measured& exchange) {
    const double area = smallerArea(ids, i, j);
    const uint32_t smaller = j < kEnvironment && ids.areas[j] < ids.areas[i] ? j : i;
    const double error = exchange.standard_error / area;
    largest = std::max(largest, bernsteinBound(error * error * blocks, ranges[smaller], blocks, p));
  });
  return largest;
}

// Blocks until Bernstein's bound is epsilon.
double blocksUntil(double epsilon, double variance, double range, double bounds, double delta) {
  double low = 2, high = 1e15;
  for (int step = 0; step < 100; ++step) {
    const double blocks = std::sqrt(low * high), looks = 1 + std::log(std::max(blocks, 10.0)) / std::log(kEpochGrowth);
    (bernsteinBound(variance, range, blocks, delta / (2 * looks * (looks + 1) * bounds)) > epsilon ? low : high) = blocks;
  }
  return high;
}

PairCounts countBlock(Engine& engine, const GuaranteeOptions& options, uint64_t directions, uint64_t block) {
  const uint64_t parts = (directions + kMostAtOnce - 1) / kMostAtOnce;  // more than one are of iid directions
  PairCounts sum;
  for (uint64_t part = 0; part < parts; ++part) {
    const uint64_t count = directions * (part + 1) / parts - directions * part / parts;
    sum = addCounts(sum, engine.count(sampleDirections(options.sampler, static_cast<uint32_t>(count), options.seed, block * parts + part)));
  }
  return sum;
}

std::vector<PairCounts> mergeIdsOfAll(const std::vector<PairCounts>& runs, const std::vector<uint32_t>& id_map) {
  std::vector<PairCounts> merged;
  for (const PairCounts& run : runs) merged.push_back(mergeIds(run, id_map));
  return merged;
}

// The medians over runs of what `means` has the means of. Standard errors as for normal errors, of which the median has pi / 2 times the mean's variance; row sums stay those of means.
FormFactors medianOf(const std::vector<PairCounts>& runs, const FormFactors& means, double measure_area) {
  std::vector<FormFactors::Entry> entries = means.entries();
  std::vector<size_t> at(runs.size(), 0);
  std::vector<uint64_t> counts(runs.size());
  for (FormFactors::Entry& entry : entries) {
    for (size_t r = 0; r < runs.size(); ++r) {
      const bool met = at[r] < runs[r].size() && runs[r][at[r]].i == entry.i && runs[r][at[r]].j == entry.j;
      counts[r] = met ? runs[r][at[r]++].count : 0;
    }
    std::nth_element(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2), counts.end());
    entry.exchange_area.value = (entry.i == entry.j ? 4 : 2) * measure_area * double(counts[counts.size() / 2]);
    entry.exchange_area.standard_error *= std::sqrt(std::numbers::pi / 2);
  }
  return {means.ids(), std::move(entries), means.rowSums()};
}

}  // namespace

std::vector<double> formFactorRanges(const Scene& scene, const Ids& ids, const std::vector<double>& resolutions, Sampling sampling) {
  const auto rangeOn = [&](uint32_t k, double resolution) {
    const ConvexSize size = sizeOf(scene, scene.polygons[k]);
    const double h = resolutions.empty() ? 0 : 2 / resolution;
    return (sampling == Sampling::scanline ? scanlineRange(size, h) : latticeRange(size, h)) * (ids.two_sided ? 2 : 1);
  };
  std::vector<double> ranges(ids.count(), 0), coarsest(ids.count(), INFINITY), finest(ids.count(), 0);
  for (uint32_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t id = ids.of_polygon[k];
    const double resolution = resolutions.empty() ? 1 : resolutions[k];
    ranges[id] += rangeOn(k, resolution);
    coarsest[id] = std::min(coarsest[id], resolution);
    finest[id] = std::max(finest[id], resolution);
  }
  // Ids of several resolutions: on each finer lattice another polygon may be counted once more, as far as their polygons of that lattice allow.
  std::map<double, std::map<uint32_t, double>> mixed;
  for (uint32_t k = 0; k < scene.polygons.size(); ++k)
    if (const uint32_t id = ids.of_polygon[k]; coarsest[id] < finest[id]) mixed[resolutions[k]][id] += rangeOn(k, resolutions[k]);
  for (const auto& [resolution, range_of] : mixed) {
    const double most = std::max_element(range_of.begin(), range_of.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->second;
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
  for (size_t k = 0; k < order.size(); ++k) bounds[order[k]] = double(order.size() - 1 - k) + 2 + (polygons[order[k]] > 1 ? 1 : 0);
  return bounds;
}

uint64_t hoeffdingDirections(const std::vector<double>& ranges, const std::vector<double>& bounds, double epsilon, double delta) {
  const auto failure = [&](double n) {
    double sum = 0;
    for (size_t k = 0; k < ranges.size(); ++k) sum += bounds[k] * 2 * std::exp(-2 * n * epsilon * epsilon / (ranges[k] * ranges[k]));
    return sum;
  };
  if (!(failure(kMostDirections) <= delta))
    throw Error(ErrorCode::bad_usage, fmt::format("a guarantee of {} takes more than {:.0e} directions where one adds up to {:.3g} to a form factor (2 but for polygons far smaller than "
                                                  "the scene); ask for a larger --epsilon, or an estimate by --tolerance",
                                                  epsilon, kMostDirections, *std::max_element(ranges.begin(), ranges.end())));
  double low = 0, high = 1;
  while (failure(high) > delta) high *= 2;
  while (high - low > 1) (failure(std::floor((low + high) / 2)) > delta ? low : high) = std::floor((low + high) / 2);
  return static_cast<uint64_t>(high);
}

double bernsteinBound(double variance, double range, double blocks, double p) {
  const double l = std::log(4 / p);
  return std::sqrt(2 * variance * l / blocks) + 7 * range * l / (3 * (blocks - 1));
}

GuaranteePlan planGuarantee(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const Lattices& lattices, Sampling sampling, bool exact) {
  const double e = options.epsilon, d = options.delta;
  if (!(e > 0 && e < 1 && d > 0 && d < 1)) throw Error(ErrorCode::bad_usage, "epsilon and delta have to lie between 0 and 1");
  const bool is_median = options.statistic == Statistic::median;
  if (options.sampler != Sampler::iid && (options.sampler != Sampler::jittered || is_median))
    throw Error(ErrorCode::bad_usage, is_median ? "the median needs independent runs of independent directions: --sampler iid"
                                                : "a guarantee needs independent directions: --sampler jittered or iid");
  const std::vector<double> bounds = countBounds(ids);

  // With lattices for one range: the bounds, and what a pilot says of the time until they are met.
  const auto planFor = [&](double range) {
    GuaranteePlan plan;
    plan.epsilon = e;
    plan.delta = d;
    plan.bounds = std::accumulate(bounds.begin(), bounds.end(), 0.0);
    plan.range = range;
    plan.groups = exact ? groupBySize(scene, std::vector<double>(scene.polygons.size(), 1), 1) : groupsFor(scene, neededFor(scene, ids, range, sampling), lattices);
    plan.engine = lattices.make_engine(plan.groups);
    plan.ranges = formFactorRanges(scene, ids, exact ? std::vector<double>{} : resolutionsOf(scene, plan.groups), sampling);
    const double m = plan.largest_range = *std::max_element(plan.ranges.begin(), plan.ranges.end());
    plan.hoeffding = hoeffdingDirections(plan.ranges, bounds, e, d / 2);
    plan.lemma_1 = std::ceil(1 / (e * e * d));
    plan.lemma_1_all = std::ceil(plan.bounds / (e * e * d));
    plan.runs = static_cast<uint64_t>(std::ceil(8 * std::log(plan.bounds / d))) | 1;
    plan.run_directions = static_cast<uint64_t>(std::ceil(std::max(4.0, m * m) / (e * e) * (1 - 1e-12)));

    const auto secondsOf = [&](uint32_t directions) {
      const auto start = Clock::now();
      plan.engine->count(sampleDirections(options.sampler, directions, options.seed, kPilot - 2));
      return secondsSince(start);
    };
    secondsOf(kPilotDirections);  // kernels are compiled and tuned
    const double few = std::min(secondsOf(1), secondsOf(1)), direction_seconds = secondsOf(kPilotDirections) / kPilotDirections;
    const double block_seconds = std::max(few - direction_seconds, 0.0);
    if (is_median) {
      plan.least_seconds = plan.expected_seconds = plan.most_seconds = double(plan.runs) * (block_seconds + double(plan.run_directions) * direction_seconds);
      return plan;
    }
    // The variance of some blocks says which size of block is expected to end first; that it does end is not at stake.
    plan.expected_seconds = INFINITY;
    for (uint32_t size : options.block_directions ? std::vector{options.block_directions} : std::vector{1u, 4u, 16u}) {
      ReplicateSums sums(ids);
      for (uint32_t b = 0; b < kPilotBlocks; ++b) sums.add(plan.engine->count(sampleDirections(options.sampler, size, options.seed, kPilot + b)));
      double variance = 0;
      sums.forEachPair(plan.engine->unitArea() * scene.scale * scene.scale / size, [&](uint32_t i, uint32_t j, const Measured& exchange) {
        const double error = exchange.standard_error / smallerArea(ids, i, j);
        variance = std::max(variance, error * error * kPilotBlocks);
      });
      const double blocks = std::min(blocksUntil(e, variance, m, plan.bounds, d), std::ceil(double(plan.hoeffding) / size));
      const double seconds = blocks * (block_seconds + size * direction_seconds);
      if (seconds >= plan.expected_seconds) continue;
      plan.block_directions = size;
      plan.expected_blocks = static_cast<uint64_t>(std::ceil(blocks));
      plan.expected_seconds = seconds;
    }
    const double block = block_seconds + plan.block_directions * direction_seconds;
    plan.most_blocks = std::max(kFewestBlocks, (plan.hoeffding + plan.block_directions - 1) / plan.block_directions);
    plan.least_blocks = static_cast<uint64_t>(std::min(double(plan.most_blocks), std::ceil(1 + 7 * m * std::log(4 * 2 * 2 * plan.bounds / d) / (3 * e))));
    plan.least_seconds = double(plan.least_blocks) * block;
    plan.most_seconds = double(plan.most_blocks) * block;
    return plan;
  };

  // Finer lattices lower ranges and variances, and cost more each.
  const bool one = exact || lattices.resolution;
  GuaranteePlan best = planFor(options.range > 0 ? options.range : one ? kRanges.back() : kRanges.front());
  for (size_t k = 1; k < kRanges.size() && !one && !(options.range > 0); ++k) {
    GuaranteePlan plan = planFor(kRanges[k]);
    if (plan.expected_seconds > 1.5 * best.expected_seconds) break;
    if (plan.expected_seconds < best.expected_seconds) best = std::move(plan);
  }
  return best;
}

Estimate guaranteeFormFactors(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const GuaranteePlan& plan) {
  const bool is_median = options.statistic == Statistic::median;
  const uint64_t directions = is_median ? plan.run_directions : plan.block_directions;
  const uint64_t most_blocks = is_median ? plan.runs : plan.most_blocks;
  RunSums sums = makeRunSums(scene, ids);
  sums.measure_area = plan.engine->unitArea() * scene.scale * scene.scale / double(directions);
  if (options.resumed) sums.add(*options.resumed);
  std::vector<PairCounts> runs;
  Guarantee guarantee{options.epsilon, options.delta, INFINITY, is_median ? GuaranteedBy::median : GuaranteedBy::hoeffding};
  // The looks at Bernstein's bound are after set numbers of blocks. Those that a run did before it was stopped found nothing.
  uint64_t look = 0, next_look = std::max<uint64_t>(2, plan.least_blocks);
  const auto passLook = [&] {
    ++look;
    next_look = static_cast<uint64_t>(std::ceil(double(next_look) * kEpochGrowth));
  };
  while (next_look < sums.replicateCount()) passLook();
  const auto isDone = [&] {
    const uint64_t blocks = sums.replicateCount();
    if (blocks >= most_blocks || is_median || blocks != next_look) return blocks >= most_blocks;
    passLook();
    guarantee.bound = largestBernsteinBound(sums.by_id, ids, plan.ranges, sums.measure_area, options.delta / (2 * double(look) * double(look + 1) * plan.bounds));
    if (guarantee.bound > options.epsilon) return false;
    guarantee.by = GuaranteedBy::bernstein;
    return true;
  };
  bool interrupted = false;
  try {
    while (!isDone()) {
      const uint64_t block = sums.replicateCount();
      PairCounts counts = countBlock(*plan.engine, options, directions, block);
      sums.add(block, counts, directions);
      if (is_median) runs.push_back(std::move(counts));
      if (options.on_sums) options.on_sums(sums, false);
      if (options.on_so_far) options.on_so_far([&] { return makeEstimate(sums, EstimateOptions{}.relative_floor); });
      if (options.on_block) options.on_block({block + 1, is_median ? plan.runs : plan.expected_blocks, most_blocks, guarantee.bound});
    }
  } catch (const Interrupted&) {
    interrupted = true;
  } catch (...) {
    if (options.on_sums) options.on_sums(sums, true);
    throw;
  }
  if (options.on_sums) options.on_sums(sums, true);
  Estimate estimate = makeEstimate(sums, EstimateOptions{}.relative_floor);
  estimate.interrupted = interrupted;
  if (interrupted) return estimate;  // an estimate is left, and no guarantee
  if (is_median) {
    estimate.form_factors = medianOf(runs, estimate.form_factors, sums.measure_area);
    estimate.between_surfaces = medianOf(mergeIdsOfAll(runs, ids.surface), estimate.between_surfaces, sums.measure_area);
  }
  if (guarantee.by != GuaranteedBy::bernstein) guarantee.bound = options.epsilon;
  estimate.guarantee = guarantee;
  return estimate;
}

}  // namespace viewpeel
