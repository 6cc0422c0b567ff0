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

#include "sums/pair_count.h"
#include "error.h"
#include "estimator/bounds.h"
#include "estimator/visible_share.h"
#include "scene/perimeter.h"

namespace viewpeel {
namespace {

constexpr double kFinestResolution = 1 << 14;  // asked for; steps of 4 end below 2^16, where corners keep 9 bits after the point
constexpr double kBaseShare = 0.9;             // of the area, that the first group's resolution is fine enough for
constexpr double kEpochGrowth = 1.15;          // of the blocks from one look at Bernstein's bound to the next
constexpr uint64_t kPilot = uint64_t(1) << 40; // replicate numbers that no run reaches
constexpr uint32_t kPilotBlocks = 24, kPilotDirections = 8;
constexpr std::array kRanges = {5.0, 3.5, 2.8, 2.4, 2.2};  // that lattices are tried for
constexpr uint32_t kSharePilotDirections = 1024;
constexpr uint64_t kFewestBlocks = 8;          // for standard errors
constexpr double kMostDirections = 1e15;       // of a guarantee; beyond 2^53 doubles do not count
constexpr uint64_t kMostAtOnce = 1 << 16;      // directions held at a time
constexpr uint64_t kTogether = 512;            // directions of several blocks counted at once

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double diameterOf(const Scene& scene, const Polygon& polygon) {
  double diameter = 0;
  for (uint32_t a = 0; a < polygon.corner_count; ++a)
    for (uint32_t b = 0; b < a; ++b) diameter = std::max(diameter, glm::length(scene.corners[polygon.first_corner + a] - scene.corners[polygon.first_corner + b]));
  return diameter;
}

ConvexSize sizeOf(const Scene& scene, const Polygon& polygon) {
  return {polygon.area, perimeterOf(scene, polygon), diameterOf(scene, polygon)};
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
  const int finest = maxWindowResolution(lattices.sampling);
  if (lattices.resolution) return groupAsOne(scene, lattices.resolution);
  const double most = *std::max_element(needed.begin(), needed.end());
  if (!lattices.may_group) return groupAsOne(scene, static_cast<int>(std::min<double>(std::ceil(most), kMaxResolution)));
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
  return groupBySize(scene, needed, static_cast<int>(std::min<double>(std::ceil(base), kMaxResolution)), finest);
}

// Blocks until a bound, bound_at(blocks, p) for all at once, is epsilon.
template <class BoundAt>
double blocksUntil(double epsilon, double delta, BoundAt bound_at) {
  double low = 2, high = 1e15;
  for (int step = 0; step < 50; ++step) {
    const double blocks = std::sqrt(low * high), looks = 1 + std::log(std::max(blocks, 10.0)) / std::log(kEpochGrowth);
    (bound_at(blocks, delta / (2 * looks * (looks + 1))) > epsilon ? low : high) = blocks;
  }
  return high;
}

// Shares from a pilot, in few directions: they serve any number of blocks.
KnownShares findShares(const GuaranteePlan& plan, const Scene& scene, const Ids& ids, const GuaranteeOptions& options) {
  EstimateOptions pilot;
  pilot.directions = kSharePilotDirections;
  pilot.sampler = options.sampler;
  pilot.seed = options.seed;
  FaceExchanges exchanges(options.device, scene, ids);
  return keepBounded(findVisibleShares(*plan.engine, exchanges, scene, ids, plan.groups, pilot, {pilot.directions}).known, ids, plan.groups.size() == 1);
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

std::vector<PairCounts> countBlocks(Engine& engine, const GuaranteeOptions& options, uint64_t directions, uint64_t first, uint64_t blocks) {
  if (blocks == 1) return {countBlock(engine, options, directions, first)};
  std::vector<Direction> all;
  for (uint64_t block = first; block < first + blocks; ++block) {
    const std::vector<Direction> own = sampleDirections(options.sampler, static_cast<uint32_t>(directions), options.seed, block);
    all.insert(all.end(), own.begin(), own.end());
  }
  return engine.countBlocks(all, directions);
}

RunSums makeGuaranteeSums(const Scene& scene, const Ids& ids, const GuaranteePlan& plan, uint64_t directions) {
  RunSums sums = makeRunSums(scene, ids);
  sums.measure_area = plan.engine->unitArea() * scene.scale * scene.scale / double(directions);
  if (plan.share_bounds) sums.visible.emplace(sums.by_id.ids(), sums.by_surface.ids(), By::polygon, plan.known);
  return sums;
}

// What all errors are below after so many blocks, but for probability p, if blocks go on to vary as those of `sums` do.
std::function<double(double blocks, double p)> boundFor(const RunSums& sums, const Ids& ids, const GuaranteePlan& plan, uint32_t block_directions) {
  if (plan.share_bounds)
    return [&plan, block_directions, variances = plan.share_bounds->measureVariances(sums.visible->faceControls(), sums.measure_area)](double blocks, double p) {
      return plan.share_bounds->largestBound(variances, blocks, block_directions, p);
    };
  // What was never met has the largest range.
  std::vector<std::pair<double, double>> entries{{0, *std::max_element(plan.ranges.begin(), plan.ranges.end())}};
  sums.by_id.forEachPair(sums.measure_area, [&](uint32_t i, uint32_t j, const Measured& exchange) {
    const uint32_t smaller = j < kEnvironment && ids.areas[j] < ids.areas[i] ? j : i;
    const double error = exchange.standard_error / ids.areas[smaller];
    entries.push_back({error * error * double(sums.replicateCount()), plan.ranges[smaller]});
  });
  return [entries = std::move(entries), bounds = plan.bounds](double blocks, double p) {
    double largest = 0;
    for (const auto& [variance, range] : entries) largest = std::max(largest, bernsteinBound(variance, range, blocks, p / bounds));
    return largest;
  };
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
  return leastDirections(failure, delta, epsilon, *std::max_element(ranges.begin(), ranges.end()));
}

uint64_t leastDirections(const std::function<double(double)>& failure, double delta, double epsilon, double range) {
  if (!(failure(kMostDirections) <= delta))
    throw Error(ErrorCode::bad_usage, fmt::format("a guarantee of {} takes more than {:.0e} directions where one adds up to {:.3g} to a form factor (2 but for polygons far smaller than "
                                                  "the scene); ask for a larger --epsilon, or an estimate by --tolerance",
                                                  epsilon, kMostDirections, range));
  double low = 0, high = 1;
  while (failure(high) > delta) high *= 2;
  while (high - low > 1) (failure(std::floor((low + high) / 2)) > delta ? low : high) = std::floor((low + high) / 2);
  return static_cast<uint64_t>(high);
}

double bernsteinBound(double variance, double range, double blocks, double p) {
  const double l = std::log(4 / p);
  return std::sqrt(2 * variance * l / blocks) + 7 * range * l / (3 * (blocks - 1));
}

GuaranteePlan planGuarantee(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const Lattices& lattices, bool exact) {
  const Sampling sampling = lattices.sampling;
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
    plan.groups = exact ? groupAsOne(scene, 1) : groupsFor(scene, neededFor(scene, ids, range, sampling), lattices);
    plan.engine = lattices.make_engine(plan.groups);
    plan.ranges = formFactorRanges(scene, ids, exact ? std::vector<double>{} : resolutionsOf(scene, plan.groups), sampling);
    const double m = plan.largest_range = *std::max_element(plan.ranges.begin(), plan.ranges.end());
    if (options.closed_forms) {
      plan.known = findShares(plan, scene, ids, options);
      plan.share_bounds.emplace(ids, plan.ranges, plan.known);
    }
    plan.hoeffding = plan.share_bounds ? plan.share_bounds->directionsFor(e, d / 2) : hoeffdingDirections(plan.ranges, bounds, e, d / 2);
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
    if (is_median) {
      const double direction_seconds = secondsOf(kPilotDirections) / kPilotDirections;
      plan.least_seconds = plan.expected_seconds = plan.most_seconds = double(plan.runs) * double(plan.run_directions) * direction_seconds;
      return plan;
    }
    // The variance of some blocks says which size of block is expected to end first; that it does end is not at stake.
    plan.expected_seconds = INFINITY;
    double block_seconds = 0;
    for (uint32_t size : options.block_directions ? std::vector{options.block_directions} : std::vector{1u, 4u, 16u}) {
      const auto start = Clock::now();
      RunSums sums = makeGuaranteeSums(scene, ids, plan, size);
      uint64_t block = 0;
      for (const PairCounts& counts : countBlocks(*plan.engine, options, size, kPilot, kPilotBlocks)) sums.add(block++, counts, size);
      const double seconds_each = secondsSince(start) / kPilotBlocks;
      const double blocks = std::min(blocksUntil(e, d, boundFor(sums, ids, plan, size)), std::ceil(double(plan.hoeffding) / size));
      const double seconds = blocks * seconds_each;
      if (seconds >= plan.expected_seconds) continue;
      plan.block_directions = size;
      plan.expected_blocks = static_cast<uint64_t>(std::ceil(blocks));
      plan.expected_seconds = seconds;
      block_seconds = seconds_each;
    }
    plan.most_blocks = std::max(kFewestBlocks, (plan.hoeffding + plan.block_directions - 1) / plan.block_directions);
    const double bounds_of_empirical = plan.share_bounds ? plan.share_bounds->rowBounds() : plan.bounds;
    plan.least_blocks = static_cast<uint64_t>(std::min(double(plan.most_blocks), std::ceil(1 + 7 * m * std::log(4 * 2 * 2 * bounds_of_empirical / d) / (3 * e))));
    plan.least_seconds = double(plan.least_blocks) * block_seconds;
    plan.most_seconds = double(plan.most_blocks) * block_seconds;
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
  RunSums sums = makeGuaranteeSums(scene, ids, plan, directions);
  if (options.resumed) {
    sums.visible.reset();  // theirs
    sums.add(*options.resumed);
  }
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
    guarantee.bound = boundFor(sums, ids, plan, static_cast<uint32_t>(directions))(double(blocks), options.delta / (2 * double(look) * double(look + 1)));
    if (guarantee.bound > options.epsilon) return false;
    guarantee.by = GuaranteedBy::bernstein;
    return true;
  };
  bool interrupted = false;
  try {
    while (!isDone()) {
      // As many at once as there are until the next look.
      uint64_t block = sums.replicateCount();
      const uint64_t end = is_median ? most_blocks : std::min(most_blocks, next_look), together = std::max<uint64_t>(kTogether / directions, 1);
      for (PairCounts& counts : countBlocks(*plan.engine, options, directions, block, std::min(end - block, together))) {
        sums.add(block, counts, directions);
        if (is_median) runs.push_back(std::move(counts));
        if (options.on_sums) options.on_sums(sums, false);
        if (options.on_so_far) options.on_so_far([&] { return makeEstimate(sums, EstimateOptions{}.relative_floor); });
        ++block;
        if (options.on_block) options.on_block({block, is_median ? plan.runs : plan.expected_blocks, most_blocks, guarantee.bound});
      }
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
  if (sums.visible) estimate.form_factors = keepSeen(sums.visible->controlledFormFactors(sums.measure_area, sums.by_id.formFactors(sums.measure_area, sums.countArea())));
  if (guarantee.by != GuaranteedBy::bernstein) guarantee.bound = options.epsilon;
  estimate.guarantee = guarantee;
  return estimate;
}

}  // namespace viewpeel
