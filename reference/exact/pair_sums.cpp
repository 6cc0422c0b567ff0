#include "reference/exact/pair_sums.h"

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

}  // namespace

Piece Piece::operator-() const {
  Piece result{-twice_area, from, to, -sign, std::nullopt};
  if (exact) result.exact = Exact{-exact->twice_area, -exact->dx, -exact->dy};
  return result;
}

void RegionSums::add(uint32_t a, uint32_t b, const Piece& piece) {
  if (a > b) std::swap(a, b);
  const uint64_t key = uint64_t{a} << 32 | b;
  Sum& sum = sums_.try_emplace(key, Sum{a, b, {}, {}}).first->second;
  sum.twice_area = sum.twice_area + piece.twice_area;
  if (options_.perimeters) {
    std::vector<Step>& steps = steps_[key];
    steps.push_back({piece.from, piece.sign});
    steps.push_back({piece.to, -piece.sign});
  }
  if (!piece.exact) return;
  if (!sum.exact) sum.exact.emplace();
  increase(*sum.exact, *piece.exact);
}

void RegionSums::closeEdge(double length) {
  for (auto& [key, steps] : steps_) {
    std::sort(steps.begin(), steps.end(), [](const Step& p, const Step& q) { return p.at < q.at; });
    int running = 0;
    for (size_t k = 0; k + 1 < steps.size(); ++k) {
      running += steps[k].change;
      if (running != 0) sums_.at(key).perimeter += length * (steps[k + 1].at - steps[k].at);
    }
  }
  steps_.clear();
}

std::vector<PairArea> RegionSums::list(const Projection& projection) const {
  std::vector<PairArea> pairs;
  const double factor = projection.areaFactor();
  for (const auto& [key, sum] : sums_) {
    PairArea pair{sum.a, sum.b, 0, 0, sum.perimeter};
    if (options_.arithmetic == Arithmetic::exact) {
      if (sum.exact->twice_area == 0) continue;
      pair.area = factor * toDouble(sum.exact->twice_area, 2 * projection.exponent());
      pair.error = 4 * Ball::kUnit * std::abs(pair.area);
    } else {
      pair.area = factor * sum.twice_area.value;
      pair.error = factor * sum.twice_area.error * 1.01 + 4 * Ball::kUnit * std::abs(pair.area);
      if (pair.area <= pair.error) continue;
    }
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const PairArea& p, const PairArea& q) { return std::tie(p.a, p.b) < std::tie(q.a, q.b); });
  return pairs;
}

void RegionSums::appendOpenPairs(std::vector<std::array<uint32_t, 2>>& open) const {
  for (const auto& [key, sum] : sums_)
    if (sum.exact->dx != 0 || sum.exact->dy != 0) open.push_back({sum.a, sum.b});
}

PairSums::PairSums(const Projection& projection, const ExactOptions& options)
    : projection_(projection), options_(options), gaps_(options), blocked_(options) {}

uint32_t PairSums::classify(uint32_t lower, uint32_t upper) const {
  const auto side = [&](uint32_t outline, bool above) {
    if (outline == kNoOutline) return kSideNone;
    return sideTowardsGap(projection_.outlines()[outline].front_up, options_.two_sided, above);
  };
  return classifyGap(side(lower, true), side(upper, false));
}

void PairSums::addGap(uint32_t lower, uint32_t upper, const Piece& piece) {
  const auto polygon = [&](uint32_t outline) { return projection_.outlines()[outline].polygon; };
  switch (classify(lower, upper)) {
    case kGapFacingPair:
      return gaps_.add(polygon(lower), polygon(upper), piece);
    case kGapLowerEnvironment:
      return gaps_.add(polygon(lower), kEnvironment, piece);
    case kGapUpperEnvironment:
      return gaps_.add(polygon(upper), kEnvironment, piece);
    case kGapLowerLeak:
      return gaps_.add(polygon(lower), kLeak, piece);
    case kGapUpperLeak:
      return gaps_.add(polygon(upper), kLeak, piece);
    default:
      return;
  }
}

void PairSums::addBlocked(uint32_t lower, uint32_t upper, const Piece& piece) {
  if (classify(lower, upper) != kGapFacingPair) return;
  blocked_.add(projection_.outlines()[lower].polygon, projection_.outlines()[upper].polygon, piece);
}

void PairSums::closeEdge(double length) {
  gaps_.closeEdge(length);
  blocked_.closeEdge(length);
}

ExactPairAreas PairSums::finish() const {
  ExactPairAreas result;
  result.pairs = gaps_.list(projection_);
  result.blocked = blocked_.list(projection_);
  if (options_.arithmetic == Arithmetic::exact) {
    result.open_polygons = findOpenPolygons();
    gaps_.appendOpenPairs(result.open_pairs);
    blocked_.appendOpenPairs(result.open_pairs);
    std::sort(result.open_pairs.begin(), result.open_pairs.end());
  }
  return result;
}

std::vector<uint32_t> PairSums::findOpenPolygons() const {
  std::vector<mpq_class> rest(projection_.scene().polygons.size());
  for (const Outline& outline : projection_.outlines())
    rest[outline.polygon] = twiceArea(projection_, outline) * (options_.two_sided ? 2 : 1);
  for (const auto& [key, sum] : gaps_.sums()) {
    rest[sum.a] -= sum.exact->twice_area;
    if (sum.b < rest.size()) rest[sum.b] -= sum.exact->twice_area;
  }
  std::vector<uint32_t> open;
  for (uint32_t polygon = 0; polygon < rest.size(); ++polygon)
    if (rest[polygon] != 0) open.push_back(polygon);
  return open;
}

}  // namespace viewpeel::reference
