#include "reference/pair_sums.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "facing.h"

namespace viewpeel::reference {
namespace {

void increase(Piece::Exact& sum, const Piece::Exact& piece) {
  sum.twice_area += piece.twice_area;
  sum.dx += piece.dx;
  sum.dy += piece.dy;
}

mpq_class twiceArea(const Projection& projection, const Outline& outline) {
  mpz_class sum = 0;
  for (size_t k = 2; k < outline.vertices.size(); ++k)
    sum += projection.exactCross(outline.vertices[0], outline.vertices[k - 1], outline.vertices[k]);
  return sum;
}

double toDouble(mpq_class x, long exponent) {
  if (exponent >= 0) mpq_mul_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(exponent));
  else mpq_div_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(-exponent));
  return x.get_d();
}

uint32_t firstOf(uint64_t key) { return static_cast<uint32_t>(key >> 32); }
uint32_t secondOf(uint64_t key) { return static_cast<uint32_t>(key); }

}  // namespace

Piece Piece::operator-() const {
  Piece result{-twice_area, from, to, -sign, std::nullopt};
  if (exact) result.exact = Exact{-exact->twice_area, -exact->dx, -exact->dy};
  return result;
}

PairSums::PairSums(const Projection& projection, const ExactOptions& options)
    : projection_(projection), options_(options) {}

void PairSums::addGap(uint32_t lower, uint32_t upper, const Piece& piece) {
  const auto side = [&](uint32_t outline, bool above) {
    if (outline == kNoOutline) return kSideNone;
    return sideTowardsGap(projection_.outlines()[outline].front_up, options_.two_sided, above);
  };
  const auto polygon = [&](uint32_t outline) { return projection_.outlines()[outline].polygon; };
  switch (classifyGap(side(lower, true), side(upper, false))) {
    case kGapFacingPair: return add(polygon(lower), polygon(upper), piece);
    case kGapLowerEnvironment: return add(polygon(lower), kEnvironment, piece);
    case kGapUpperEnvironment: return add(polygon(upper), kEnvironment, piece);
    case kGapLowerLeak: return add(polygon(lower), kLeak, piece);
    case kGapUpperLeak: return add(polygon(upper), kLeak, piece);
    default: return;
  }
}

void PairSums::add(uint32_t a, uint32_t b, const Piece& piece) {
  Sum& sum = sums_[uint64_t{std::min(a, b)} << 32 | std::max(a, b)];
  sum.twice_area = sum.twice_area + piece.twice_area;
  if (options_.perimeters) {
    std::vector<Step>& steps = steps_[uint64_t{std::min(a, b)} << 32 | std::max(a, b)];
    steps.push_back({piece.from, piece.sign});
    steps.push_back({piece.to, -piece.sign});
  }
  if (!piece.exact) return;
  if (!sum.exact) sum.exact.emplace();
  increase(*sum.exact, *piece.exact);
}

void PairSums::closeEdge(double length) {
  for (auto& [key, steps] : steps_) {
    std::sort(steps.begin(), steps.end(), [](const Step& p, const Step& q) { return p.at < q.at; });
    int running = 0;
    for (size_t k = 0; k + 1 < steps.size(); ++k) {
      running += steps[k].change;
      if (running != 0) sums_[key].perimeter += length * (steps[k + 1].at - steps[k].at);
    }
  }
  steps_.clear();
}

ExactPairAreas PairSums::finish() const {
  ExactPairAreas result;
  const double factor = projection_.areaFactor();
  for (const auto& [key, sum] : sums_) {
    PairArea pair{firstOf(key), secondOf(key), 0, 0, sum.perimeter};
    if (options_.arithmetic == Arithmetic::exact) {
      if (sum.exact->twice_area == 0) continue;
      pair.area = factor * toDouble(sum.exact->twice_area, 2 * projection_.exponent());
      pair.error = 4 * Ball::kUnit * std::abs(pair.area);
    } else {
      pair.area = factor * sum.twice_area.value;
      pair.error = factor * sum.twice_area.error * 1.01 + 4 * Ball::kUnit * std::abs(pair.area);
      if (pair.area <= pair.error) continue;
    }
    result.pairs.push_back(pair);
  }
  std::sort(result.pairs.begin(), result.pairs.end(),
            [](const PairArea& p, const PairArea& q) { return std::tie(p.a, p.b) < std::tie(q.a, q.b); });
  if (options_.arithmetic == Arithmetic::exact) {
    result.open_polygons = findOpenPolygons();
    result.open_pairs = findOpenPairs();
  }
  return result;
}

std::vector<uint32_t> PairSums::findOpenPolygons() const {
  std::vector<mpq_class> rest(projection_.scene().polygons.size());
  for (const Outline& outline : projection_.outlines())
    rest[outline.polygon] = twiceArea(projection_, outline) * (options_.two_sided ? 2 : 1);
  for (const auto& [key, sum] : sums_) {
    rest[firstOf(key)] -= sum.exact->twice_area;
    if (secondOf(key) < rest.size()) rest[secondOf(key)] -= sum.exact->twice_area;
  }
  std::vector<uint32_t> open;
  for (uint32_t polygon = 0; polygon < rest.size(); ++polygon)
    if (rest[polygon] != 0) open.push_back(polygon);
  return open;
}

std::vector<std::array<uint32_t, 2>> PairSums::findOpenPairs() const {
  std::vector<std::array<uint32_t, 2>> open;
  for (const auto& [key, sum] : sums_)
    if (sum.exact->dx != 0 || sum.exact->dy != 0) open.push_back({firstOf(key), secondOf(key)});
  std::sort(open.begin(), open.end());
  return open;
}

}  // namespace viewpeel::reference
