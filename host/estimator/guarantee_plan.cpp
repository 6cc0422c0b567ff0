#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "directions/replicates.h"
#include <viewpeel/error.h>
#include "estimator/bounds.h"
#include "estimator/guarantee.h"
#include "estimator/guarantee_blocks.h"
#include "estimator/find_prior.h"
#include "stopwatch.h"

namespace viewpeel {
namespace {

// No polygon asks for a finer lattice than this. Windows have the base resolution times powers of 4, and so end below
// 2^16, where snapped corners still have 9 bits for fractions of a spacing.
constexpr double kFinestWindowResolution = 1 << 14;
constexpr double kBaseShare = 0.9;  // the whole scene's lattice is fine enough for this share of all area
constexpr uint32_t kPilotBlocks = 24, kPilotBlockDirections = 8;
constexpr std::array kRanges = {5.0, 3.5, 2.8, 2.4, 2.2};  // ranges M of eq. (27) that are tried
constexpr std::array kBlockDirections = {1u, 4u, 16u};     // numbers of directions of a block
constexpr uint32_t kPriorPilotDirections = 1024;
constexpr uint64_t kFewestBlocks = 8;  // fewer blocks give too rough a standard error
// If a lattice takes more than this multiple of the best time so far, finer lattices are not tried.
constexpr double kDearer = 1.5;

// Returns the resolution at which the range of each polygon's id is at most `range`: double[polygon]. No resolution is
// above kFinestWindowResolution.
std::vector<double> neededFor(const Scene& scene, const Ids& ids, double range, Sampling sampling) {
  // The terms of eq. (27), or (28), are summed over an id's polygons: 2 A + slope h + number h^2 = range A has one
  // positive root h. The slope is the sum of perimeters, or with scanlines 2.01 times the sum of diameters, where the
  // 0.01 exceeds the 2^-9 of eq. (28).
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
    const double c = (range - 2) * areas[id],
                 h = 2 * c / (slopes[id] + std::sqrt(slopes[id] * slopes[id] + 4 * numbers[id] * c));
    needed.push_back(std::min(2 / h, kFinestWindowResolution));
  }
  return needed;
}

std::vector<double> resolutionsOf(const Scene& scene, const std::vector<SizeGroup>& groups) {
  std::vector<double> resolutions(scene.polygons.size(), 0);
  for (const SizeGroup& group : groups)
    for (uint32_t k : group.polygons) resolutions[k] = group.resolution;
  return resolutions;
}

// Returns the groups of polygons for one range. One lattice serves most of the area. Polygons that need a finer lattice
// get windows.
std::vector<SizeGroup> groupsFor(const Scene& scene, const std::vector<double>& needed, const Lattices& lattices) {
  const int finest = maxWindowResolution(lattices.lattice.sampling);
  if (lattices.resolution) return groupAsOne(scene, lattices.resolution);
  const double most = *std::max_element(needed.begin(), needed.end());
  if (!lattices.may_group)
    return groupAsOne(scene, static_cast<int>(std::min<double>(std::ceil(most), kMaxResolution)));
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

// Returns the number of blocks at which bound_at(blocks, p), the largest of all bounds, falls to epsilon. Here p is the
// part of delta that the look after so many blocks has.
template <class BoundAt>
double blocksUntil(double epsilon, double delta, BoundAt bound_at) {
  double low = 2, high = 1e15;
  for (int step = 0; step < 50; ++step) {
    const double blocks = std::sqrt(low * high), looks = 1 + std::log(std::max(blocks, 10.0)) / std::log(kEpochGrowth);
    (bound_at(blocks, delta / (2 * looks * (looks + 1))) > epsilon ? low : high) = blocks;
  }
  return high;
}

// Returns the prior of a guarantee. Its pilot has few directions, because any visibility keeps the bounds valid.
Prior findBoundedPrior(const GuaranteePlan& plan, const Scene& scene, const Ids& ids, const GuaranteeOptions& options) {
  EstimateOptions pilot;
  pilot.directions = kPriorPilotDirections;
  pilot.sampler = options.sampler;
  pilot.seed = options.seed;
  FaceExchanges exchanges(options.device, scene, ids);
  return keepBounded(findPrior(*plan.engine, exchanges, scene, ids, plan.groups, pilot, {pilot.directions}).prior, ids,
                     plan.groups.size() == 1);
}

class GuaranteePlanner {
 public:
  GuaranteePlanner(const Scene& scene, const Ids& ids, const GuaranteeOptions& options, const Lattices& lattices,
                   bool exact)
      : scene_(scene), ids_(ids), options_(options), lattices_(lattices), exact_(exact), bounds_(countBounds(ids)) {}

  // Returns the plan that is expected to end first. Finer lattices have smaller ranges and variances, but each of their
  // directions costs more.
  GuaranteePlan plan() const {
    const bool has_one_lattice = exact_ || lattices_.resolution;
    if (options_.range > 0 || has_one_lattice) return planFor(options_.range > 0 ? options_.range : kRanges.back());
    GuaranteePlan best = planFor(kRanges.front());
    for (size_t k = 1; k < kRanges.size(); ++k) {
      GuaranteePlan plan = planFor(kRanges[k]);
      if (plan.expected_seconds > kDearer * best.expected_seconds) break;
      if (plan.expected_seconds < best.expected_seconds) best = std::move(plan);
    }
    return best;
  }

 private:
  // Returns the plan for one range: its lattices, its bounds, and the time that a pilot predicts.
  GuaranteePlan planFor(double range) const {
    GuaranteePlan plan = makeLattices(range);
    findDirections(plan);
    // The first count compiles and tunes kernels, so its time does not count.
    secondsOf(plan, kPilotBlockDirections);
    if (options_.statistic == Statistic::median) {
      const double direction_seconds = secondsOf(plan, kPilotBlockDirections) / kPilotBlockDirections;
      plan.least_seconds = plan.expected_seconds = plan.most_seconds =
          double(plan.runs) * double(plan.run_directions) * direction_seconds;
      return plan;
    }
    chooseBlocks(plan);
    return plan;
  }

  GuaranteePlan makeLattices(double range) const {
    GuaranteePlan plan;
    plan.epsilon = options_.epsilon;
    plan.delta = options_.delta;
    plan.range = range;
    plan.bounds = std::accumulate(bounds_.begin(), bounds_.end(), 0.0);
    const Sampling sampling = lattices_.lattice.sampling;
    plan.groups =
        exact_ ? groupAsOne(scene_, 1) : groupsFor(scene_, neededFor(scene_, ids_, range, sampling), lattices_);
    plan.engine = makeEngine(lattices_, scene_, ids_, plan.groups);
    plan.ranges =
        formFactorRanges(scene_, ids_, exact_ ? std::vector<double>{} : resolutionsOf(scene_, plan.groups), sampling);
    plan.largest_range = *std::max_element(plan.ranges.begin(), plan.ranges.end());
    if (options_.unoccluded) {
      plan.prior = findBoundedPrior(plan, scene_, ids_, options_);
      plan.visibility_bounds.emplace(ids_, plan.ranges, plan.prior);
    }
    return plan;
  }

  // Sets the numbers of directions that suffice whatever the samples are: by Hoeffding's bound (29), by the paper's
  // Lemma 1, and for its median (docs/method.md, section 9).
  void findDirections(GuaranteePlan& plan) const {
    const double e = plan.epsilon, d = plan.delta, m = plan.largest_range;
    plan.hoeffding = plan.visibility_bounds ? plan.visibility_bounds->directionsFor(e, d / 2)
                                            : hoeffdingDirections(plan.ranges, bounds_, e, d / 2);
    plan.lemma_1 = std::ceil(1 / (e * e * d));
    plan.lemma_1_all = std::ceil(plan.bounds / (e * e * d));
    plan.runs = static_cast<uint64_t>(std::ceil(8 * std::log(plan.bounds / d))) | 1;
    plan.run_directions = static_cast<uint64_t>(std::ceil(std::max(4.0, m * m) / (e * e) * (1 - 1e-12)));
  }

  double secondsOf(const GuaranteePlan& plan, uint32_t directions) const {
    const auto start = Clock::now();
    plan.engine->count(sampleDirections(options_.sampler, directions, options_.seed, kTrialReplicates.end - 2));
    return secondsSince(start);
  }

  // Chooses the number of directions in a block. The variance of some pilot blocks predicts which size ends first. A
  // wrong prediction costs time, but the guarantee holds for any size.
  void chooseBlocks(GuaranteePlan& plan) const {
    const double e = plan.epsilon, d = plan.delta;
    plan.expected_seconds = INFINITY;
    double block_seconds = 0;
    for (uint32_t size : options_.block_directions
                             ? std::vector{options_.block_directions}
                             : std::vector<uint32_t>(kBlockDirections.begin(), kBlockDirections.end())) {
      const auto start = Clock::now();
      RunSums sums = makeGuaranteeSums(scene_, ids_, plan, size);
      uint64_t block = 0;
      for (const PairCounts& counts : countBlocks(*plan.engine, options_, size, kPlanReplicates.first, kPilotBlocks))
        sums.add(block++, counts, size);
      const double seconds_each = secondsSince(start) / kPilotBlocks;
      const double blocks =
          std::min(blocksUntil(e, d, boundFor(sums, ids_, plan, size)), std::ceil(double(plan.hoeffding) / size));
      const double seconds = blocks * seconds_each;
      if (seconds >= plan.expected_seconds) continue;
      plan.block_directions = size;
      plan.expected_blocks = static_cast<uint64_t>(std::ceil(blocks));
      plan.expected_seconds = seconds;
      block_seconds = seconds_each;
    }
    plan.most_blocks = std::max(kFewestBlocks, (plan.hoeffding + plan.block_directions - 1) / plan.block_directions);
    const double bounds_of_empirical = plan.visibility_bounds ? plan.visibility_bounds->rowBounds() : plan.bounds;
    plan.least_blocks = static_cast<uint64_t>(
        std::min(double(plan.most_blocks),
                 std::ceil(1 + 7 * plan.largest_range * std::log(4 * 2 * 2 * bounds_of_empirical / d) / (3 * e))));
    plan.least_seconds = double(plan.least_blocks) * block_seconds;
    plan.most_seconds = double(plan.most_blocks) * block_seconds;
  }

  const Scene& scene_;
  const Ids& ids_;
  const GuaranteeOptions& options_;
  const Lattices& lattices_;
  bool exact_;
  std::vector<double> bounds_;  // as countBounds() returns them
};

}  // namespace

GuaranteePlan planGuarantee(const Scene& scene, const Ids& ids, const GuaranteeOptions& options,
                            const Lattices& lattices, bool exact) {
  const double e = options.epsilon, d = options.delta;
  if (!(e > 0 && e < 1 && d > 0 && d < 1))
    throw Error(ErrorCode::bad_usage, "epsilon and delta have to lie between 0 and 1");
  const bool is_median = options.statistic == Statistic::median;
  if (options.sampler != Sampler::iid && (options.sampler != Sampler::jittered || is_median))
    throw Error(ErrorCode::bad_usage, is_median
                                          ? "the median needs independent runs of independent directions: --sampler iid"
                                          : "a guarantee needs independent directions: --sampler jittered or iid");
  return GuaranteePlanner(scene, ids, options, lattices, exact).plan();
}

}  // namespace viewpeel
