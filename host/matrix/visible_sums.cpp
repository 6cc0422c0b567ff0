#include "matrix/visible_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace viewpeel {
namespace {

// Exchanges between surfaces, of those of their faces: sums, at most the areas of the two.
std::vector<KnownExchange> mergeBySurface(const std::vector<KnownExchange>& exchanges, bool has_all_pairs, const std::vector<uint32_t>& surface, const std::vector<double>& areas) {
  std::vector<KnownExchange> mapped;
  mapped.reserve(exchanges.size());
  for (const KnownExchange& e : exchanges) {
    const uint32_t i = surface[e.i], j = e.j < kEnvironment ? surface[e.j] : e.j;
    // Two faces of one surface exchange both ways within it.
    const double ways = i == j ? 2 : 1;
    mapped.push_back({std::min(i, j), std::max(i, j), ways * e.area, ways * e.most, e.line});
  }
  std::sort(mapped.begin(), mapped.end(), [](const auto& a, const auto& b) { return std::pair(a.i, a.j) < std::pair(b.i, b.j); });
  std::vector<KnownExchange> merged;
  for (const KnownExchange& e : mapped) {
    if (merged.empty() || std::pair(merged.back().i, merged.back().j) != std::pair(e.i, e.j)) {
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

VisibleSums::VisibleSums(const Ids& face_ids, const Ids& surface_ids, By by, KnownShares known)
    : by_(by), known_(std::move(known)), by_face_(face_ids), by_surface_(surface_ids) {
  prepare();
}

VisibleSums::VisibleSums(By by, KnownShares known, ControlSums by_face, ControlSums by_surface)
    : by_(by), known_(std::move(known)), by_face_(std::move(by_face)), by_surface_(std::move(by_surface)) {
  prepare();
}

void VisibleSums::prepare() {
  const std::vector<double>& areas = by_face_.ids().areas;
  std::vector<KnownExchange> for_surfaces;
  for (const KnownPair& pair : known_.pairs) {
    if (pair.share) shares_.push_back({pair.i, pair.j, pair.share});
    if (pair.surface_share) surface_shares_.push_back({pair.i, pair.j, pair.surface_share});
    const bool is_pair = pair.j < kEnvironment;
    const uint64_t line = is_pair ? std::min(known_.lines[pair.i], known_.lines[pair.j]) : known_.lines[pair.i];
    // Closed forms exceed areas by rounding.
    const double most = std::min({pair.exchange, areas[pair.i], is_pair ? areas[pair.j] : INFINITY});
    exchanges_.push_back({pair.i, pair.j, most * pair.share / kShareOne, most, line});
    for_surfaces.push_back({pair.i, pair.j, most * pair.surface_share / kShareOne, most, line});
  }
  surface_exchanges_ = mergeBySurface(for_surfaces, known_.has_all_pairs, by_face_.ids().surface, by_surface_.ids().areas);
}

void VisibleSums::add(const PairCounts& counts) {
  const PairCounts with_rows = withRows(counts);
  std::vector<ControlCount> of_faces = takeShares(with_rows, shares_, known_.lines);
  by_surface_.add(mergeIds(takeShares(with_rows, surface_shares_, known_.lines), by_face_.ids().surface));
  by_face_.add(of_faces);
}

void VisibleSums::add(const VisibleSums& others, bool others_are_first) {
  by_face_.add(others.by_face_);
  by_surface_.add(others.by_surface_);
  if (!others_are_first) return;
  known_ = others.known_;
  exchanges_ = others.exchanges_;
  surface_exchanges_ = others.surface_exchanges_;
}

bool VisibleSums::goesWith(const VisibleSums& others) const {
  const auto sharesOf = [](const VisibleSums& sums) {
    std::vector<std::array<uint32_t, 4>> shares;
    for (const KnownPair& pair : sums.known_.pairs)
      if (pair.share || pair.surface_share) shares.push_back({pair.i, pair.j, pair.share, pair.surface_share});
    return shares;
  };
  return by_ == others.by_ && known_.lines == others.known_.lines && known_.has_all_pairs == others.known_.has_all_pairs && sharesOf(*this) == sharesOf(others);
}

FormFactors VisibleSums::formFactors(By by, double measure_area, const FormFactors& sampled) const {
  const bool of_faces = by == By::polygon;
  return chooseBetter((of_faces ? by_face_ : by_surface_).formFactors(measure_area, of_faces ? exchanges_ : surface_exchanges_), sampled);
}

FormFactors VisibleSums::controlledFormFactors(double measure_area, const FormFactors& sampled) const {
  return {sampled.ids(), by_face_.formFactors(measure_area, exchanges_).entries(), sampled.rowSums()};
}

}  // namespace viewpeel
