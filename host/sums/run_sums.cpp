#include "sums/run_sums.h"

#include <algorithm>
#include <cmath>

#include "sums/line_form_factors.h"
#include "sums/pair_walk.h"
#include "threads.h"

namespace viewpeel {
namespace {

// Returns the ranges sorted. Ranges that follow each other without a gap are joined.
std::vector<ReplicateRange> joinRanges(std::vector<ReplicateRange> ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const ReplicateRange& a, const ReplicateRange& b) { return a.first < b.first; });
  std::vector<ReplicateRange> joined;
  for (const ReplicateRange& range : ranges) {
    if (!joined.empty() && joined.back().end == range.first) joined.back().end = range.end;
    else joined.push_back(range);
  }
  return joined;
}

}  // namespace

RunSums makeRunSums(const Scene& scene, const Ids& ids) {
  Ids surface_ids = makeIds(scene, By::surface, ids.two_sided);
  surface_ids.rows_sum_to_one = ids.rows_sum_to_one;
  if (!ids.requested.empty()) {
    surface_ids.requested.assign(surface_ids.count(), false);
    for (uint32_t k = 0; k < ids.count(); ++k)
      if (ids.requested[k]) surface_ids.requested[ids.surface[k]] = true;
  }
  if (!ids.only_blocks.empty()) {
    surface_ids.only_blocks.assign(surface_ids.count(), true);
    for (uint32_t k = 0; k < ids.count(); ++k)
      if (!ids.only_blocks[k]) surface_ids.only_blocks[ids.surface[k]] = false;
  }
  return {ReplicateSums(ids), ReplicateSums(std::move(surface_ids)), {}};
}

double RunSums::countArea() const {
  return by_id.ids().requested.empty() && replicateCount()
             ? measure_area * double(directions) / double(replicateCount())
             : INFINITY;
}

bool RunSums::isWhole() const {
  uint64_t count = 0;
  for (size_t k = 0; k < replicates.size(); ++k) {
    if (replicates[k].first >= replicates[k].end || (k && replicates[k].first <= replicates[k - 1].end)) return false;
    count += replicates[k].end - replicates[k].first;
  }
  if (hasPairsInVisible() && !by_id.pairs().empty()) return false;
  if (lines && lines->replicateCount() != count) return false;
  return by_id.replicateCount() == count && by_surface.replicateCount() == count &&
         (!prior_sums ||
          (prior_sums->byFace().replicateCount() == count && prior_sums->surfaceControls().replicateCount() == count &&
           prior_sums->directed().replicateCount() == count));
}

void RunSums::countRays(std::vector<uint32_t> of_faces) {
  rays = std::move(of_faces);
  const Ids& faces = by_id.ids();
  const double directions_of_replicate = rays.empty() ? 0 : std::ranges::max(rays);
  std::vector<double> areas(faces.count()), areas_of_surfaces(by_surface.ids().count());
  for (uint32_t k = 0; k < faces.count(); ++k) {
    areas[k] = faces.areas[k] * directions_of_replicate / rays[k];
    double& largest = areas_of_surfaces[faces.surface[k]];
    largest = std::max(largest, areas[k]);
  }
  by_id.countRays(std::move(areas));
  by_surface.countRays(std::move(areas_of_surfaces));
}

void RunSums::setLineSteps(std::vector<double> of_ids) {
  line_steps = std::move(of_ids);
  std::vector<double> of_surfaces(by_surface.ids().count(), 1);
  for (uint32_t k = 0; k < line_steps.size(); ++k) {
    double& largest = of_surfaces[by_id.ids().surface[k]];
    largest = std::max(largest, line_steps[k]);
  }
  by_id.setLineSteps(line_steps);
  by_surface.setLineSteps(std::move(of_surfaces));
}

// Notes that a replicate is done.
void RunSums::note(uint64_t replicate, uint64_t direction_count) {
  replicates.push_back({replicate, replicate + 1});
  replicates = joinRanges(std::move(replicates));
  directions += direction_count;
}

void RunSums::add(uint64_t replicate, const PairCounts& counts, uint64_t direction_count, const PairCounts& directed) {
  const auto addTo = [&](size_t, size_t k) {
    if (k == 0 && prior_sums) prior_sums->add(counts, directed);
    if (k == 1) by_surface.add(mergeIds(counts, by_id.ids().surface));
    if (k == 2) hasPairsInVisible() ? by_id.addRows(counts) : by_id.add(counts);
  };
  shareOut(threadsFor(counts.size()), 3, 1, addTo);
  note(replicate, direction_count);
}

void RunSums::addLines(uint64_t replicate, const PairCounts& counts, uint64_t direction_count,
                       const LineCounts& line_counts) {
  lines->add(line_counts);
  add(replicate, counts, direction_count);
}

void RunSums::addOutside(uint64_t replicate, const PairCounts& counts, uint64_t direction_count,
                         const LineCounts& line_counts, const std::vector<bool>& rows) {
  lines->add(line_counts);
  if (lines->by() == By::polygon) {
    by_id.addOutside(counts, rows);
    by_surface.addOutside({}, {});
  } else {
    by_id.addOutside({}, {});
    by_surface.addOutside(mergeIds(counts, by_id.ids().surface), rows);
  }
  note(replicate, direction_count);
}

void RunSums::add(const RunSums& others) {
  if (lines && !replicates.empty()) lines->add(*others.lines);
  else lines = others.lines;
  if (replicates.empty()) measure_area = others.measure_area;
  if (others.prior_sums && !prior_sums) prior_sums = others.prior_sums;
  else if (prior_sums)
    prior_sums->add(*others.prior_sums,
                    !others.replicates.empty() &&
                        (replicates.empty() || others.replicates.front().first < replicates.front().first));
  by_surface.add(others.by_surface);
  by_id.add(others.by_id);
  replicates.insert(replicates.end(), others.replicates.begin(), others.replicates.end());
  replicates = joinRanges(std::move(replicates));
  directions += others.directions;
}

FormFactors RunSums::formFactors(const ExchangeRow& row) const {
  if (lines && lines->by() == By::polygon)
    return lineFormFactors(*lines, By::polygon, by_id, measure_area, countArea());
  if (lines || (prior_sums && prior_sums->by() == By::surface)) return betweenSurfaces();
  if (!prior_sums) return by_id.formFactors(measure_area, countArea());
  // Only pairs that are estimated by counts alone need these entries.
  const std::vector<VisibilitySums::PairSum>& pairs = prior_sums->byFace().pairs();
  std::vector<FormFactors::Entry> sampled;
  sampled.reserve(pairs.size());
  PairWalk priors(prior_sums->prior().pairs);
  for (const VisibilitySums::PairSum& pair : pairs) {
    const PairPrior* const prior = priors.find(pair);
    if (pair.facing == 0 || (prior && !prior_sums->isCountedAlone(*prior, double(directions), countArea()))) continue;
    const ReplicateSums::PairSum counted{pair.i, pair.j, {pair.facing, prior_sums->byFace().squaresOf(pair).facing}};
    sampled.push_back({pair.i, pair.j, by_id.exchangeArea(counted, measure_area, countArea())});
  }
  return prior_sums->byPolygon(measure_area, countArea(), by_id, sampled, row);
}

FormFactors RunSums::priorFormFactors() const {
  std::vector<FormFactors::Entry> entries = prior_sums->ofPriorPairs(measure_area, countArea(), by_id);
  auto at = prior_sums->prior().pairs.begin();  // entries has one entry for each of these pairs
  std::erase_if(entries, [&](const FormFactors::Entry&) {
    return prior_sums->isCountedAlone(*at++, double(directions), countArea());
  });
  return {by_id.ids(), std::move(entries), {}};
}

FormFactors RunSums::betweenSurfaces() const {
  if (lines) return lineFormFactors(*lines, By::surface, by_surface, measure_area, countArea());
  const FormFactors sampled = by_surface.formFactors(measure_area, countArea());
  return prior_sums ? prior_sums->bySurface(measure_area, countArea(), sampled) : sampled;
}

ReplicateRange findShared(const std::vector<ReplicateRange>& a, const std::vector<ReplicateRange>& b) {
  for (const ReplicateRange& of_b : b)
    for (const ReplicateRange& of_a : a) {
      const ReplicateRange shared{std::max(of_a.first, of_b.first), std::min(of_a.end, of_b.end)};
      if (shared.first < shared.end) return shared;
    }
  return {};
}

}  // namespace viewpeel
