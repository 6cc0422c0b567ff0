#include "estimator/find_prior.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "directions/replicates.h"
#include "engines/lattice.h"
#include "estimator/directed_pairs.h"
#include "sums/add_pairs.h"
#include "sums/pair_count.h"
#include "sums/pair_walk.h"
#include "scene/rank_by_place.h"
#include "stopwatch.h"

namespace viewpeel {
namespace {

constexpr uint32_t kPriorPilots = 8;

// Returns the visibilities of the pairs that `others` have as well.
std::vector<PairVisibility> shared(const std::vector<PairVisibility>& visibilities,
                                   const std::vector<PairVisibility>& others) {
  std::vector<PairVisibility> both;
  std::set_intersection(visibilities.begin(), visibilities.end(), others.begin(), others.end(),
                        std::back_inserter(both),
                        [](const PairVisibility& a, const PairVisibility& b) { return keyOf(a) < keyOf(b); });
  return both;
}

// Returns the visibilities that make the estimates of the pilots vary less than they do without visibilities.
//   Each half of the pilots is tried with the visibilities of the other half. With its own visibilities, a pair of few
//   lines would look better than it is.
//   In: id_map: uint32_t[face], the id that each face belongs to; empty: faces are the ids
std::vector<PairVisibility> keepUseful(const std::vector<PairVisibility>& visibilities,
                                       const std::vector<PairCounts>& pilots, const Ids& ids,
                                       const std::vector<uint32_t>& id_map) {
  const size_t half = pilots.size() / 2;
  std::vector<FormFactors> controlled, counted;
  for (const bool second : {false, true}) {
    const auto begin = pilots.begin() + static_cast<std::ptrdiff_t>(second ? half : 0),
               end = begin + static_cast<std::ptrdiff_t>(half);
    PairCounts others;
    for (size_t k = 0; k < half; ++k) others = addCounts(others, pilots[second ? k : half + k]);
    const std::vector<PairVisibility> tried = shared(fitVisibilities(others), visibilities);
    ControlVariateSums with(ids), without(ids);
    for (auto counts = begin; counts != end; ++counts) {
      const auto addTo = [&](ControlVariateSums& sums, const std::vector<ControlVariate>& controls) {
        sums.add(id_map.empty() ? controls : mergeIds(controls, id_map));
      };
      addTo(with, takeControlVariates(*counts, tried));
      addTo(without, takeControlVariates(*counts, {}));
    }
    controlled.push_back(with.formFactors(1, {}));
    counted.push_back(without.formFactors(1, {}));
  }
  const auto errorOf = [](const std::vector<FormFactors>& halves, uint32_t i, uint32_t j) {
    return std::hypot(halves[0].exchangeArea(i, j).standard_error, halves[1].exchangeArea(i, j).standard_error);
  };
  std::vector<PairVisibility> kept;
  for (const PairVisibility& visibility : visibilities) {
    const uint32_t i = id_map.empty() ? visibility.i : id_map[visibility.i],
                   j = id_map.empty() || visibility.j >= kEnvironment ? visibility.j : id_map[visibility.j];
    if (errorOf(controlled, std::min(i, j), std::max(i, j)) <= errorOf(counted, std::min(i, j), std::max(i, j)))
      kept.push_back(visibility);
  }
  return kept;
}

}  // namespace

std::vector<PairVisibility> fitVisibilities(const PairCounts& counts) {
  std::vector<PairVisibility> visibilities;
  for (const PairCount& count : counts) {
    if (count.i == count.j || count.count == 0) continue;
    const double visibility = double(count.count) / (double(count.count) + double(count.blocked));
    const auto rounded = static_cast<uint32_t>(std::lround(visibility * kVisibilityOne));
    if (rounded > 0) visibilities.push_back({count.i, count.j, rounded});
  }
  return visibilities;
}

PriorPilot choosePriorPilot(const EstimateOptions& options) {
  const bool by_surface = options.by == By::surface,
             chooses_pairs = options.pairs && (options.tolerance || options.relative);
  return {by_surface || chooses_pairs ? options.directions : (options.directions + 3) / 4,
          by_surface ? kMostPriorPairs : kMostPriorPairsBesideRows};
}

std::vector<uint64_t> countsOfLines(const Ids& face_ids, const std::vector<SizeGroup>& groups, double unit_area) {
  std::vector<uint64_t> lines(face_ids.count(), 1);
  for (const SizeGroup& group : groups)
    for (uint32_t k : group.polygons) {
      uint64_t& line = lines[face_ids.of_polygon[k]];
      line = std::max(line, static_cast<uint64_t>(std::llround(pointArea(group.resolution) / unit_area)));
    }
  return lines;
}

std::vector<double> meanStepsOfLines(const Scene& scene, const Ids& ids, const std::vector<SizeGroup>& groups,
                                     double unit_area, Sampling sampling) {
  const std::vector<uint64_t> lines = countsOfLines(ids, groups, unit_area);
  std::vector<double> steps;
  for (uint32_t id = 0; id < ids.count(); ++id)
    steps.push_back(lineStep(double(lines[id]), sampling == Sampling::scanline, ids.areas[id] / ids.sides(),
                             unit_area * scene.scale * scene.scale));
  return steps;
}

FoundPrior findPrior(Engine& engine, FaceExchanges& exchanges, const Scene& scene, const Ids& ids,
                     const std::vector<SizeGroup>& groups, const EstimateOptions& options, PriorPilot pilot) {
  FoundPrior found;
  auto start = Clock::now();
  std::vector<PairCounts> pilots;
  PairCounts all;
  const uint32_t each = (pilot.directions + kPriorPilots - 1u) / kPriorPilots;
  for (uint32_t k = 0; k < kPriorPilots; ++k) {
    pilots.push_back(engine.count(sampleDirections(options.sampler, each, options.seed, kPriorReplicates.first + k)));
    all = addCounts(all, pilots.back());
  }
  all = withRows(std::move(all));
  const std::vector<PairVisibility> seen = fitVisibilities(all);
  for (PairCounts& counts : pilots) counts = withRows(std::move(counts), seen);
  // A visibility from few lines adds more noise than it takes away, and is dropped. This is decided for each pair of
  // faces, and again for each pair of surfaces, because sums over a surface vary less than their terms.
  const std::vector<PairVisibility> visibilities = keepUseful(fitVisibilities(all), pilots, ids, {});
  const std::vector<PairVisibility> surface_visibilities =
      keepUseful(visibilities, pilots, makeIds(scene, By::surface, ids.two_sided), ids.surface);
  found.pilot_seconds = secondsSince(start);

  start = Clock::now();
  const uint64_t n = ids.count();
  found.prior.lines = countsOfLines(ids, groups, engine.unitArea());
  if (pairCount(n) <= kMostRowPairs) found.prior.ranks = rankByPlace(scene, ids.of_polygon, ids.count());
  found.prior.has_all_pairs = pairCount(n) <= pilot.most_prior_pairs;
  std::vector<PairPrior>& pairs = found.prior.pairs;
  if (found.prior.has_all_pairs) {
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = i + 1; j < n; ++j) pairs.push_back({i, j});
  }
  for (const PairVisibility& visibility : visibilities)
    if (visibility.j >= kEnvironment || !found.prior.has_all_pairs) pairs.push_back({visibility.i, visibility.j});
  std::sort(pairs.begin(), pairs.end(), [](const PairPrior& a, const PairPrior& b) { return keyOf(a) < keyOf(b); });
  const auto visibilityOf = [](auto& walk, const PairPrior& pair) {
    const PairVisibility* const found_pair = walk.find(pair);
    return found_pair ? found_pair->visibility : 0;
  };
  PairWalk of_faces(visibilities), of_surfaces(surface_visibilities);
  for (PairPrior& pair : pairs) {
    pair.visibility = visibilityOf(of_faces, pair);
    pair.surface_visibility = visibilityOf(of_surfaces, pair);
  }

  // If no line of a pilot was blocked between a face and any other, the face most likely sees all of its partners, even
  // where no line hit the pair.
  std::vector<bool> is_blocked(n, false);
  bool is_any_blocked = false;
  for (const PairCount& count : all)
    if (count.j < kEnvironment && count.blocked) is_any_blocked = is_blocked[count.i] = is_blocked[count.j] = true;
  for (PairPrior& pair : pairs) {
    if (pair.j >= kEnvironment || is_blocked[pair.i] || is_blocked[pair.j]) continue;
    pair.visibility = kVisibilityOne;
    if (!is_any_blocked) pair.surface_visibility = kVisibilityOne;
  }

  found.unreached = exchanges.compute(pairs);
  std::erase_if(pairs, [](const PairPrior& pair) { return pair.exchange == 0; });
  found.unoccluded_seconds = secondsSince(start);

  // Directed pairs are for goals by polygon only. Two surfaces have many pairs of faces, so common directions hit them
  // often enough.
  if (!options.pairs || options.by != By::polygon) return found;
  start = Clock::now();
  const CommonPilots common{pilots, each, engine.unitArea() * scene.scale * scene.scale};
  found.prior.directed = chooseDirectedPairs(*options.pairs, ids, found.prior, common, options);
  found.directed_seconds = secondsSince(start);
  return found;
}

}  // namespace viewpeel
