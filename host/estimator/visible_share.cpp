#include "estimator/visible_share.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include "engines/pair_counters.h"
#include "error.h"

namespace viewpeel {
namespace {

constexpr uint64_t kSharePilot = uint64_t(3) << 40;  // replicates that no run reaches
constexpr uint32_t kPilots = 8;

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::vector<KnownExchange> mergeBySurface(const std::vector<KnownExchange>& exchanges, const std::vector<uint32_t>& surface) {
  std::vector<KnownExchange> mapped;
  mapped.reserve(exchanges.size());
  for (const KnownExchange& e : exchanges) {
    const uint32_t i = surface[e.i], j = surface[e.j];
    // Two polygons of one surface exchange both ways within it.
    mapped.push_back({std::min(i, j), std::max(i, j), i == j ? 2 * e.area : e.area, INFINITY});
  }
  std::sort(mapped.begin(), mapped.end(), [](const auto& a, const auto& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); });
  std::vector<KnownExchange> merged;
  for (const KnownExchange& e : mapped) {
    if (!merged.empty() && merged.back().i == e.i && merged.back().j == e.j) merged.back().area += e.area;
    else merged.push_back(e);
  }
  return merged;
}

// Those of `shares` whose pairs are among `others`.
std::vector<PairShare> shared(const std::vector<PairShare>& shares, const std::vector<PairShare>& others) {
  std::vector<PairShare> both;
  std::set_intersection(shares.begin(), shares.end(), others.begin(), others.end(), std::back_inserter(both),
                        [](const PairShare& a, const PairShare& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); });
  return both;
}

// Those with which the pilots vary less than without, in the sums of ids that id_map makes of faces (none: faces themselves). Each half of the pilots is tried
// with the shares that the other half has, so that shares which few lines told do not look better than they are.
std::vector<PairShare> keepUseful(const std::vector<PairShare>& shares, const std::vector<PairCounts>& pilots, const Ids& ids, const std::vector<uint32_t>& id_map) {
  const size_t half = pilots.size() / 2;
  std::vector<FormFactors> controlled, counted;
  for (const bool second : {false, true}) {
    const auto begin = pilots.begin() + static_cast<std::ptrdiff_t>(second ? half : 0), end = begin + static_cast<std::ptrdiff_t>(half);
    PairCounts others;
    for (size_t k = 0; k < half; ++k) others = addCounts(others, pilots[second ? k : half + k]);
    const std::vector<PairShare> tried = shared(fitShares(others), shares);
    ControlSums with(ids), without(ids);
    for (auto counts = begin; counts != end; ++counts) {
      const auto addTo = [&](ControlSums& sums, const std::vector<ControlCount>& controls) { sums.add(id_map.empty() ? controls : mergeIds(controls, id_map)); };
      addTo(with, takeShares(*counts, tried));
      addTo(without, takeShares(*counts, {}));
    }
    controlled.push_back(with.formFactors(1, {}));
    counted.push_back(without.formFactors(1, {}));
  }
  const auto errorOf = [](const std::vector<FormFactors>& halves, uint32_t i, uint32_t j) {
    return std::hypot(halves[0].exchangeArea(i, j).standard_error, halves[1].exchangeArea(i, j).standard_error);
  };
  std::vector<PairShare> kept;
  for (const PairShare& share : shares) {
    const uint32_t i = id_map.empty() ? share.i : id_map[share.i], j = id_map.empty() ? share.j : id_map[share.j];
    if (errorOf(controlled, std::min(i, j), std::max(i, j)) <= errorOf(counted, std::min(i, j), std::max(i, j))) kept.push_back(share);
  }
  return kept;
}

}  // namespace

std::vector<PairShare> fitShares(const PairCounts& counts) {
  std::vector<PairShare> shares;
  for (const PairCount& count : counts) {
    if (count.j >= kEnvironment || count.i == count.j || count.count == 0) continue;
    const double share = double(count.count) / (double(count.count) + double(count.blocked));
    const auto rounded = static_cast<uint32_t>(std::lround(share * kShareOne));
    if (rounded > 0) shares.push_back({count.i, count.j, rounded});
  }
  return shares;
}

VisibleShares findVisibleShares(Engine& engine, const Device& device, const Scene& scene, const Ids& ids, const EstimateOptions& options) {
  VisibleShares found;
  auto start = Clock::now();
  std::vector<PairCounts> pilots;
  PairCounts all;
  for (uint32_t k = 0; k < kPilots; ++k) {
    pilots.push_back(engine.count(sampleDirections(options.sampler, (options.directions + kPilots - 1u) / kPilots, options.seed, kSharePilot + k)));
    all = addCounts(all, pilots.back());
  }
  // A share that few lines told adds more noise than it takes away: then counts are left alone, pair by pair of faces, and of surfaces, whose sums vary less than their parts.
  const std::vector<PairShare> shares = keepUseful(fitShares(all), pilots, ids, {});
  const std::vector<PairShare> surface_shares = keepUseful(shares, pilots, makeIds(scene, By::surface, ids.two_sided), ids.surface);
  found.pilot_seconds = secondsSince(start);

  start = Clock::now();
  std::vector<std::vector<uint32_t>> polygons(ids.count());
  for (uint32_t k = 0; k < ids.of_polygon.size(); ++k) polygons[ids.of_polygon[k]].push_back(k);
  std::vector<SidePair> sides;
  std::vector<uint32_t> face_pair;  // of each of `sides`
  for (uint32_t s = 0; s < shares.size(); ++s)
    for (uint32_t p : polygons[shares[s].i])
      for (uint32_t q : polygons[shares[s].j])
        for (uint32_t side = 0; side < (ids.two_sided ? 4u : 1u); ++side) {
          sides.push_back({frontSide(p) + side % 2, frontSide(q) + side / 2});
          face_pair.push_back(s);
        }
  std::vector<double> areas(sides.size());
  std::vector<bool> is_reached(shares.size(), true);
  if (!sides.empty())
    for (const UnreachedPair& pair : UnoccludedExchange(device, scene).compute(sides, areas)) is_reached[face_pair[pair.pair]] = false;
  std::vector<double> exchange(shares.size(), 0);
  for (size_t k = 0; k < sides.size(); ++k) exchange[face_pair[k]] += areas[k] * scene.scale * scene.scale;
  for (size_t s = 0; s < shares.size(); ++s) {
    if (!is_reached[s]) {
      ++found.unreached;
      continue;
    }
    found.shares.push_back(shares[s]);
    const double most = std::min({exchange[s], ids.areas[shares[s].i], ids.areas[shares[s].j]});  // which closed forms exceed by rounding
    found.exchanges.push_back({shares[s].i, shares[s].j, most * shares[s].share / kShareOne, most});
  }
  found.surface_shares = shared(surface_shares, found.shares);
  std::vector<KnownExchange> surface_exchanges;
  for (size_t k = 0, at = 0; k < found.shares.size() && at < found.surface_shares.size(); ++k) {
    if (found.shares[k].i != found.surface_shares[at].i || found.shares[k].j != found.surface_shares[at].j) continue;
    surface_exchanges.push_back(found.exchanges[k]);
    ++at;
  }
  found.surface_exchanges = mergeBySurface(surface_exchanges, ids.surface);
  found.closed_form_seconds = secondsSince(start);
  return found;
}

Estimate estimateVisibleShares(Engine& engine, const Scene& scene, const Ids& ids, By by, const EstimateOptions& options, const VisibleShares& known) {
  RunSums sums = makeRunSums(scene, ids);
  sums.measure_area = engine.unitArea() * scene.scale * scene.scale / options.directions;
  ControlSums controls(ids), surface_controls(makeIds(scene, By::surface, ids.two_sided));
  const auto start = Clock::now();
  const auto resultBy = [&](By result) {
    const ControlSums& chosen = result == By::polygon ? controls : surface_controls;
    const ReplicateSums& sampled = result == By::polygon ? sums.by_id : sums.by_surface;
    return chooseBetter(chosen.formFactors(sums.measure_area, result == By::polygon ? known.exchanges : known.surface_exchanges), sampled.formFactors(sums.measure_area));
  };
  double largest_error = INFINITY, largest_relative_error = INFINITY;
  const auto isDone = [&] {
    const auto done = double(sums.replicateCount());
    if (options.seconds && done >= 2 && secondsSince(start) * (done + 1) / done > *options.seconds) return true;
    return sums.replicateCount() >= options.replicates && (!options.tolerance || largest_error <= *options.tolerance) &&
           (!options.relative || largest_relative_error <= *options.relative) && !(options.seconds && !options.tolerance && !options.relative);
  };
  bool interrupted = false;
  const auto estimateSoFar = [&]() -> Estimate {
    FormFactors result = resultBy(by);
    const double error = largestStandardError(result), relative_error = largestRelativeError(result, options.relative_floor);
    return {std::move(result), resultBy(By::surface), sums.replicateCount(), sums.directions, error, relative_error, interrupted, {}};
  };
  try {
    while (!isDone()) {
      const uint64_t replicate = sums.replicateCount();
      const PairCounts counts = engine.count(sampleDirections(options.sampler, options.directions, options.seed, replicate));
      surface_controls.add(mergeIds(takeShares(counts, known.surface_shares), ids.surface));
      controls.add(takeShares(counts, known.shares));
      sums.add(replicate, counts, options.directions);
      if (sums.replicateCount() >= options.replicates || options.on_replicate) {
        const FormFactors so_far = resultBy(by);
        largest_error = largestStandardError(so_far);
        largest_relative_error = largestRelativeError(so_far, options.relative_floor);
      }
      if (options.on_so_far) options.on_so_far(estimateSoFar);
      if (options.on_replicate) options.on_replicate({sums.replicateCount(), largest_error});
    }
  } catch (const Interrupted&) {
    interrupted = true;
  }
  return estimateSoFar();
}

}  // namespace viewpeel
