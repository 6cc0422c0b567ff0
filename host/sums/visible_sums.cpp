#include "sums/visible_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "sums/add_pairs.h"
#include "sums/neighbour_shares.h"
#include "threads.h"

namespace viewpeel {
namespace {

// Exchanges between surfaces, of those of their faces: sums, at most the areas of the two.
std::vector<KnownExchange> mergeBySurface(const std::vector<KnownExchange>& exchanges, bool has_all_pairs,
                                          const std::vector<uint32_t>& surface, const std::vector<double>& areas) {
  std::vector<KnownExchange> mapped;
  mapped.reserve(exchanges.size());
  for (const KnownExchange& e : exchanges) {
    const uint32_t i = surface[e.i], j = e.j < kEnvironment ? surface[e.j] : e.j;
    // Two faces of one surface exchange both ways within it.
    const double ways = i == j ? 2 : 1;
    mapped.push_back({std::min(i, j), std::max(i, j), ways * e.area, ways * e.most, e.line});
  }
  std::sort(mapped.begin(), mapped.end(), [](const auto& a, const auto& b) { return keyOf(a) < keyOf(b); });
  std::vector<KnownExchange> merged;
  for (const KnownExchange& e : mapped) {
    if (merged.empty() || keyOf(merged.back()) != keyOf(e)) {
      merged.push_back(e);
      continue;
    }
    merged.back().area += e.area;
    merged.back().most += e.most;
    merged.back().line = std::max(merged.back().line, e.line);
  }
  for (KnownExchange& e : merged) {
    if (!has_all_pairs || e.j >= kEnvironment) e.most = INFINITY;
    e.most = std::min({e.most, areas[e.i], e.j < kEnvironment ? areas[e.j] : INFINITY});
  }
  return merged;
}

}  // namespace

std::vector<ControlCount> takeDirectedShares(const PairCounts& counts, const std::vector<DirectedPair>& directed) {
  std::vector<PairShare> shares;
  for (const DirectedPair& pair : directed) shares.push_back({pair.i, pair.j, pair.share});
  std::vector<ControlCount> controls = takeShares(counts, shares);
  for (ControlCount& control : controls) {
    control.line = std::ranges::lower_bound(directed, keyOf(control), {}, keyOf<DirectedPair>)->line;
    control.squares *= control.line;
  }
  return controls;
}

VisibleSums::VisibleSums(const Ids& face_ids, const Ids& surface_ids, By by, KnownShares known)
    : by_(by), known_(std::move(known)), by_face_(face_ids), by_surface_(surface_ids), directed_(face_ids) {
  prepare();
}

VisibleSums::VisibleSums(By by, KnownShares known, ShareSums by_face, ControlSums by_surface, ControlSums directed)
    : by_(by),
      known_(std::move(known)),
      by_face_(std::move(by_face)),
      by_surface_(std::move(by_surface)),
      directed_(std::move(directed)) {
  prepare();
}

void VisibleSums::prepare() {
  const std::vector<double>& areas = by_face_.ids().areas;
  std::vector<KnownExchange> for_surfaces;
  auto directed = known_.directed.begin();
  for (const KnownPair& pair : known_.pairs) {
    if (pair.share) shares_.push_back({pair.i, pair.j, pair.share});
    if (pair.surface_share) surface_shares_.push_back({pair.i, pair.j, pair.surface_share});
    if (pair.j >= kEnvironment && (pair.share || pair.surface_share))
      row_shares_.push_back({pair.i, pair.j, pair.share});
    if (directed != known_.directed.end() && keyOf(*directed) == keyOf(pair)) {
      directed_exchanges_.push_back(exchangeOf(pair, directed->share, areas, {}));
      directed_exchanges_.back().line = directed->line;
      ++directed;
      for_surfaces.push_back({pair.i, pair.j, 0, 0, lineOf(known_.lines, pair.i, pair.j)});
      continue;
    }
    const bool is_learnt = !known_.has_all_pairs && pair.share == 0 &&
                           pair.surface_share == 0;  // from the run: no part of what was fixed beforehand
    if (!is_learnt) for_surfaces.push_back(exchangeOf(pair, pair.surface_share, areas, known_.lines));
  }
  surface_exchanges_ =
      mergeBySurface(for_surfaces, known_.has_all_pairs, by_face_.ids().surface, by_surface_.ids().areas);
}

PairCounts VisibleSums::withoutDirected(PairCounts counts) const {
  if (!known_.directed.empty())
    std::erase_if(counts, [&](const PairCount& count) {
      const auto key = keyOf(count);
      const auto at = std::ranges::lower_bound(known_.directed, key, {}, keyOf<DirectedPair>);
      return at != known_.directed.end() && keyOf(*at) == key;
    });
  return counts;
}

void VisibleSums::add(const PairCounts& counts, const PairCounts& directed) {
  const PairCounts common = withoutDirected(withRows(counts, row_shares_)), none;
  const auto addTo = [&](size_t, size_t k) {
    if (k == 0) by_surface_.add(mergeIds(takeShares(common, surface_shares_, known_.lines), by_face_.ids().surface));
    if (k == 1) by_face_.add(by_ == By::polygon ? common : none);
  };
  directed_.add(takeDirectedShares(directed, known_.directed));
  shareOut(threadsFor(common.size()), 2, 1, addTo);
}

std::vector<KnownPair> VisibleSums::unknownPairs(uint64_t least_lines) const {
  std::vector<KnownPair> unknown;
  if (known_.has_all_pairs) return unknown;
  auto at = known_.pairs.begin();
  for (const ShareSums::PairSum& pair : by_face_.pairs()) {
    while (at != known_.pairs.end() && keyOf(*at) < keyOf(pair)) ++at;
    const bool is_known = at != known_.pairs.end() && keyOf(*at) == keyOf(pair);
    if (!is_known && pair.facing > 0 &&
        pair.facing + pair.blocked >= least_lines * lineOf(known_.lines, pair.i, pair.j) && pair.j < kEnvironment &&
        pair.i != pair.j)
      unknown.push_back({pair.i, pair.j});
  }
  return unknown;
}

void VisibleSums::learn(const std::vector<KnownPair>& pairs) {
  addPairs(known_.pairs, pairs, [](KnownPair& known, const KnownPair& pair) { known = pair; });
}

void VisibleSums::add(const VisibleSums& others, bool others_are_first) {
  by_face_.add(others.by_face_);
  by_surface_.add(others.by_surface_);
  directed_.add(others.directed_);
  KnownShares second = others.known_;
  if (others_are_first) {
    std::swap(known_, second);
    surface_exchanges_ = others.surface_exchanges_;
    directed_exchanges_ = others.directed_exchanges_;
  }
  // What only one of them has met.
  std::vector<KnownPair> missing;
  std::ranges::set_difference(second.pairs, known_.pairs, std::back_inserter(missing),
                              [](const KnownPair& a, const KnownPair& b) { return keyOf(a) < keyOf(b); });
  if (!missing.empty()) learn(missing);
}

bool VisibleSums::goesWith(const VisibleSums& others) const {
  const auto sharesOf = [](const VisibleSums& sums) {
    std::vector<std::array<uint32_t, 4>> shares;
    for (const KnownPair& pair : sums.known_.pairs)
      if (pair.share || pair.surface_share) shares.push_back({pair.i, pair.j, pair.share, pair.surface_share});
    return shares;
  };
  return by_ == others.by_ && known_.lines == others.known_.lines &&
         known_.has_all_pairs == others.known_.has_all_pairs && sharesOf(*this) == sharesOf(others);
}

std::vector<FormFactors::Entry> VisibleSums::directedEntries() const {
  std::vector<FormFactors::Entry> entries;
  for (size_t k = 0; k < known_.directed.size(); ++k) {
    const DirectedPair& pair = known_.directed[k];
    entries.push_back(
        {pair.i, pair.j, directed_.exchangeArea(pair.measure_area, directed_exchanges_[k], pair.count_area)});
  }
  return entries;
}

bool VisibleSums::isCountedAlone(const KnownPair& pair, double directions, double count_area) const {
  if (std::isinf(pair.exchange)) return true;
  const bool is_learnt = !known_.has_all_pairs && known_.ranks.empty() && pair.share == 0 && pair.surface_share == 0;
  if (!is_learnt || pair.j >= kEnvironment) return false;
  const std::vector<double>& areas = by_face_.ids().areas;
  return !isSharedPair(directions, count_area, pair.exchange, std::min(areas[pair.i], areas[pair.j]));
}

ShareSums::Found VisibleSums::find(double measure_area, double count_area, const ReplicateSums& counted,
                                   const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const {
  std::optional<NeighbourShares> neighbours;
  if (!known_.ranks.empty()) neighbours.emplace(by_face_, known_.lines, known_.ranks);
  ShareSums::Found found =
      by_face_.find(known_.pairs, known_.lines, measure_area, count_area, counted.rowSums(), sampled,
                    neighbours ? &*neighbours : nullptr, neighbours ? row : ExchangeRow{});
  std::vector<uint32_t> measured;                                 // entries that directions of their own have made
  for (const FormFactors::Entry& directed : directedEntries()) {  // among the pairs known, so there
    const auto at = std::ranges::lower_bound(found.entries, keyOf(directed), {}, keyOf<FormFactors::Entry>);
    at->exchange_area = directed.exchange_area;
    measured.push_back(static_cast<uint32_t>(at - found.entries.begin()));
  }
  if (!measured.empty())
    std::erase_if(found.guesses, [&](const Guess& guess) { return std::ranges::binary_search(measured, guess.entry); });
  return found;
}

FormFactors VisibleSums::byPolygon(double measure_area, double count_area, const ReplicateSums& counted,
                                   const std::vector<FormFactors::Entry>& sampled, const ExchangeRow& row) const {
  ShareSums::Found found = find(measure_area, count_area, counted, sampled, row);
  const std::vector<double>& areas = by_face_.ids().areas;
  calibrateRows(found.entries, found.guesses, areas);
  std::vector<Measured> rows = sumRows(found.entries, areas);
  return {by_face_.ids(), std::move(found.entries), std::move(rows)};
}

std::vector<FormFactors::Entry> VisibleSums::ofKnownPairs(double measure_area, double count_area,
                                                          const ReplicateSums& counted) const {
  return find(measure_area, count_area, counted, {}, {}).entries;
}

FormFactors VisibleSums::bySurface(double measure_area, double count_area, const FormFactors& sampled) const {
  // Directed pairs have random numbers of their own: their variances add up with that of the others.
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

bool VisibleSums::directsAs(const VisibleSums& others) const {
  const auto countsOf = [](const DirectedPair& pair) {
    return std::array{pair.i, pair.j, pair.directions, pair.resolution, pair.share, pair.line};
  };
  return std::ranges::equal(known_.directed, others.known_.directed, {}, countsOf, countsOf);
}

FormFactors VisibleSums::controlledFormFactors(double measure_area, const FormFactors& sampled) const {
  std::vector<KnownExchange> exchanges;
  for (const KnownPair& pair : known_.pairs)
    exchanges.push_back(exchangeOf(pair, pair.share, by_face_.ids().areas, known_.lines));
  return {sampled.ids(), faceControls().formFactors(measure_area, exchanges).entries(), sampled.rowSums()};
}

}  // namespace viewpeel
