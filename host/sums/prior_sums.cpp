#include "sums/prior_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "sums/add_pairs.h"
#include "sums/pair_walk.h"
#include "sums/neighbour_visibility.h"
#include "sums/row_sums.h"
#include "threads.h"

namespace viewpeel {
namespace {

// Returns the prior exchange areas between surfaces: sums over the pairs of their faces, at most the surfaces' areas.
std::vector<PriorExchange> mergeBySurface(const std::vector<PriorExchange>& exchanges, bool has_all_pairs,
                                          const std::vector<uint32_t>& surface, const std::vector<double>& areas) {
  std::vector<PriorExchange> mapped;
  mapped.reserve(exchanges.size());
  for (const PriorExchange& e : exchanges) {
    const uint32_t i = surface[e.i], j = e.j < kEnvironment ? surface[e.j] : e.j;
    // A surface's exchange with itself has each pair of its faces twice, once in either direction.
    const double ways = i == j ? 2 : 1;
    mapped.push_back({std::min(i, j), std::max(i, j), ways * e.area, ways * e.most, e.line});
  }
  std::sort(mapped.begin(), mapped.end(), [](const auto& a, const auto& b) { return keyOf(a) < keyOf(b); });
  std::vector<PriorExchange> merged;
  for (const PriorExchange& e : mapped) {
    if (merged.empty() || keyOf(merged.back()) != keyOf(e)) {
      merged.push_back(e);
      continue;
    }
    merged.back().area += e.area;
    merged.back().most += e.most;
    merged.back().line = std::max(merged.back().line, e.line);
  }
  for (PriorExchange& e : merged) {
    if (!has_all_pairs || e.j >= kEnvironment) e.most = INFINITY;
    e.most = std::min({e.most, areas[e.i], e.j < kEnvironment ? areas[e.j] : INFINITY});
  }
  return merged;
}

}  // namespace

std::vector<ControlVariate> takeDirectedControlVariates(const PairCounts& counts,
                                                        const std::vector<DirectedPair>& directed) {
  std::vector<PairVisibility> visibilities;
  for (const DirectedPair& pair : directed) visibilities.push_back({pair.i, pair.j, pair.visibility});
  std::vector<ControlVariate> controls = takeControlVariates(counts, visibilities);
  for (ControlVariate& control : controls) {
    control.line = std::ranges::lower_bound(directed, keyOf(control), {}, keyOf<DirectedPair>)->line;
    control.squares *= control.line;
  }
  return controls;
}

PriorSums::PriorSums(const Ids& face_ids, const Ids& surface_ids, By by, Prior prior)
    : by_(by), prior_(std::move(prior)), by_face_(face_ids), by_surface_(surface_ids), directed_(face_ids) {
  prepare();
}

PriorSums::PriorSums(By by, Prior prior, VisibilitySums by_face, ControlVariateSums by_surface,
                     ControlVariateSums directed)
    : by_(by),
      prior_(std::move(prior)),
      by_face_(std::move(by_face)),
      by_surface_(std::move(by_surface)),
      directed_(std::move(directed)) {
  prepare();
}

void PriorSums::prepare() {
  const std::vector<double>& areas = by_face_.ids().areas;
  std::vector<PriorExchange> for_surfaces;
  PairWalk directed_pairs(prior_.directed);
  for (const PairPrior& pair : prior_.pairs) {
    if (pair.visibility) visibilities_.push_back({pair.i, pair.j, pair.visibility});
    if (pair.surface_visibility) surface_visibilities_.push_back({pair.i, pair.j, pair.surface_visibility});
    if (pair.j >= kEnvironment && (pair.visibility || pair.surface_visibility))
      row_visibilities_.push_back({pair.i, pair.j, pair.visibility});
    if (const DirectedPair* const directed = directed_pairs.find(pair)) {
      directed_exchanges_.push_back(exchangeOf(pair, directed->visibility, areas, {}));
      directed_exchanges_.back().line = directed->line;
      for_surfaces.push_back({pair.i, pair.j, 0, 0, lineOf(prior_.lines, pair.i, pair.j)});
      continue;
    }
    // A pair that the run itself added is no part of the prior, which must be fixed before the run.
    const bool is_learnt = !prior_.has_all_pairs && pair.visibility == 0 && pair.surface_visibility == 0;
    if (!is_learnt) for_surfaces.push_back(exchangeOf(pair, pair.surface_visibility, areas, prior_.lines));
  }
  surface_exchanges_ =
      mergeBySurface(for_surfaces, prior_.has_all_pairs, by_face_.ids().surface, by_surface_.ids().areas);
}

PairCounts PriorSums::withoutDirected(PairCounts counts) const {
  if (!prior_.directed.empty())
    std::erase_if(counts, [&](const PairCount& count) {
      const auto key = keyOf(count);
      const auto at = std::ranges::lower_bound(prior_.directed, key, {}, keyOf<DirectedPair>);
      return at != prior_.directed.end() && keyOf(*at) == key;
    });
  return counts;
}

void PriorSums::add(const PairCounts& counts, const PairCounts& directed) {
  const PairCounts common = withoutDirected(withRows(counts, row_visibilities_)), none;
  const auto addTo = [&](size_t, size_t k) {
    if (k == 0)
      by_surface_.add(
          mergeIds(takeControlVariates(common, surface_visibilities_, prior_.lines), by_face_.ids().surface));
    if (k == 1) by_face_.add(by_ == By::polygon ? common : none);
  };
  directed_.add(takeDirectedControlVariates(directed, prior_.directed));
  shareOut(threadsFor(common.size()), 2, 1, addTo);
}

std::vector<PairPrior> PriorSums::pairsOutsidePrior(uint64_t least_lines) const {
  std::vector<PairPrior> unknown;
  if (prior_.has_all_pairs) return unknown;
  PairWalk priors(prior_.pairs);
  for (const VisibilitySums::PairSum& pair : by_face_.pairs())
    if (!priors.find(pair) && pair.facing > 0 &&
        pair.facing + pair.blocked >= least_lines * lineOf(prior_.lines, pair.i, pair.j) && pair.j < kEnvironment &&
        pair.i != pair.j)
      unknown.push_back({pair.i, pair.j});
  return unknown;
}

void PriorSums::learn(const std::vector<PairPrior>& pairs) {
  addPairs(prior_.pairs, pairs, [](PairPrior& prior, const PairPrior& pair) { prior = pair; });
}

void PriorSums::add(const PriorSums& others, bool others_are_first) {
  by_face_.add(others.by_face_);
  by_surface_.add(others.by_surface_);
  directed_.add(others.directed_);
  Prior second = others.prior_;
  if (others_are_first) {
    std::swap(prior_, second);
    surface_exchanges_ = others.surface_exchanges_;
    directed_exchanges_ = others.directed_exchanges_;
  }
  // Pairs that only the second prior has are added to the first.
  std::vector<PairPrior> missing;
  std::ranges::set_difference(second.pairs, prior_.pairs, std::back_inserter(missing),
                              [](const PairPrior& a, const PairPrior& b) { return keyOf(a) < keyOf(b); });
  if (!missing.empty()) learn(missing);
}

bool PriorSums::goesWith(const PriorSums& others) const {
  const auto visibilitiesOf = [](const PriorSums& sums) {
    std::vector<std::array<uint32_t, 4>> visibilities;
    for (const PairPrior& pair : sums.prior_.pairs)
      if (pair.visibility || pair.surface_visibility)
        visibilities.push_back({pair.i, pair.j, pair.visibility, pair.surface_visibility});
    return visibilities;
  };
  return by_ == others.by_ && prior_.lines == others.prior_.lines &&
         prior_.has_all_pairs == others.prior_.has_all_pairs && visibilitiesOf(*this) == visibilitiesOf(others);
}

std::vector<FormFactors::Entry> PriorSums::directedEntries() const {
  std::vector<FormFactors::Entry> entries;
  for (size_t k = 0; k < prior_.directed.size(); ++k) {
    const DirectedPair& pair = prior_.directed[k];
    entries.push_back(
        {pair.i, pair.j, directed_.exchangeArea(pair.measure_area, directed_exchanges_[k], pair.count_area)});
  }
  return entries;
}

bool PriorSums::isCountedAlone(const PairPrior& pair, double directions, double count_area) const {
  if (std::isinf(pair.exchange)) return true;
  const bool is_learnt =
      !prior_.has_all_pairs && prior_.ranks.empty() && pair.visibility == 0 && pair.surface_visibility == 0;
  if (!is_learnt || pair.j >= kEnvironment) return false;
  const std::vector<double>& areas = by_face_.ids().areas;
  return !isEstimatedByVisibility(directions, count_area, pair.exchange, std::min(areas[pair.i], areas[pair.j]));
}

VisibilitySums::Found PriorSums::find(double measure_area, double count_area, const ReplicateSums& counted,
                                      const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const {
  std::optional<NeighbourVisibility> neighbours;
  if (!prior_.ranks.empty()) neighbours.emplace(by_face_, prior_.lines, prior_.ranks);
  VisibilitySums::Found found =
      by_face_.find(prior_.pairs, prior_.lines, measure_area, count_area, counted.rowSums(), sampled,
                    neighbours ? &*neighbours : nullptr, neighbours ? row : ExchangeRow{});
  // The prior has all directed pairs, so `found` has entries for them; `measured` lists the indices of these entries.
  std::vector<uint32_t> measured;
  for (const FormFactors::Entry& directed : directedEntries()) {
    const auto at = std::ranges::lower_bound(found.entries, keyOf(directed), {}, keyOf<FormFactors::Entry>);
    at->exchange_area = directed.exchange_area;
    measured.push_back(static_cast<uint32_t>(at - found.entries.begin()));
  }
  if (!measured.empty())
    std::erase_if(found.guesses, [&](const Guess& guess) { return std::ranges::binary_search(measured, guess.entry); });
  return found;
}

FormFactors PriorSums::byPolygon(double measure_area, double count_area, const ReplicateSums& counted,
                                 const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const {
  VisibilitySums::Found found = find(measure_area, count_area, counted, sampled, row);
  const std::vector<double>& areas = by_face_.ids().areas;
  calibrateRows(found.entries, found.guesses, areas);
  std::vector<Measured> rows = sumRows(found.entries, areas);
  return {by_face_.ids(), std::move(found.entries), std::move(rows)};
}

std::vector<FormFactors::Entry> PriorSums::ofPriorPairs(double measure_area, double count_area,
                                                        const ReplicateSums& counted) const {
  return find(measure_area, count_area, counted, {}, {}).entries;
}

FormFactors PriorSums::bySurface(double measure_area, double count_area, const FormFactors& sampled) const {
  // Directed pairs use separate random numbers, so their variances add to the variances of other pairs.
  const FormFactors others =
      by_surface_.allowForUnmet(by_surface_.formFactors(measure_area, surface_exchanges_, count_area), measure_area,
                                surface_exchanges_, count_area);
  std::vector<FormFactors::Entry> entries = others.entries();
  const std::vector<uint32_t>& surface = by_face_.ids().surface;
  for (const FormFactors::Entry& directed : directedEntries()) {
    const auto [i, j] = std::minmax(surface[directed.i], surface[directed.j]);
    Measured& sum = std::ranges::lower_bound(entries, std::pair(i, j), {}, keyOf<FormFactors::Entry>)->exchange_area;
    const double ways = i == j ? 2 : 1;
    sum.value += ways * directed.exchange_area.value;
    sum.standard_error = std::hypot(sum.standard_error, ways * directed.exchange_area.standard_error);
  }
  std::vector<FormFactors::Entry> better = chooseBetter({others.ids(), std::move(entries), {}}, sampled).entries();
  std::vector<Measured> rows = sumRows(better, others.ids().areas);
  return {others.ids(), std::move(better), std::move(rows)};
}

bool PriorSums::directsAs(const PriorSums& others) const {
  const auto countsOf = [](const DirectedPair& pair) {
    return std::array{pair.i, pair.j, pair.directions, pair.resolution, pair.visibility, pair.line};
  };
  return std::ranges::equal(prior_.directed, others.prior_.directed, {}, countsOf, countsOf);
}

FormFactors PriorSums::controlledFormFactors(double measure_area, const FormFactors& sampled) const {
  std::vector<PriorExchange> exchanges;
  for (const PairPrior& pair : prior_.pairs)
    exchanges.push_back(exchangeOf(pair, pair.visibility, by_face_.ids().areas, prior_.lines));
  return {sampled.ids(), faceControls().formFactors(measure_area, exchanges).entries(), sampled.rowSums()};
}

}  // namespace viewpeel
