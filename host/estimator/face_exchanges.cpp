#include "estimator/face_exchanges.h"

#include <algorithm>
#include <cmath>

#include "sums/run_sums.h"

namespace viewpeel {
namespace {

constexpr size_t kFacePairsAtOnce = size_t(1) << 19;  // pairs of faces computed between two calls of on_chunk

}  // namespace

FaceExchanges::FaceExchanges(const Device* device, const Scene& scene, const Ids& ids, std::function<void()> on_chunk)
    : scene_(scene), ids_(ids), device_(device), on_chunk_(std::move(on_chunk)), polygons_(ids.count()) {
  for (uint32_t k = 0; k < ids.of_polygon.size(); ++k) polygons_[ids.of_polygon[k]].push_back(k);
}

uint64_t FaceExchanges::compute(std::span<PairPrior> pairs) {
  uint64_t unreached = 0;
  for (size_t first = 0; first < pairs.size(); first += kFacePairsAtOnce) {
    if (on_chunk_) on_chunk_();
    unreached += computeChunk(pairs.subspan(first, std::min(kFacePairsAtOnce, pairs.size() - first)));
  }
  return unreached;
}

void FaceExchanges::learn(RunSums& sums) {
  if (!sums.prior_sums) return;
  std::vector<PairPrior> found = sums.prior_sums->pairsOutsidePrior(hasRows() ? kLinesToLearn : kLinesForVisibility);
  compute(found);
  for (PairPrior& pair : found)
    // A line hit the pair, so its unoccluded form factor is not 0, although it was computed as 0: one face lies in the
    // other's plane within rounding.
    if (pair.exchange == 0) pair.exchange = INFINITY;
  sums.prior_sums->learn(found);
}

bool FaceExchanges::hasRows() const { return pairCount(ids_.count()) <= kMostRowPairs; }

ExchangeRow FaceExchanges::rows() {
  if (!hasRows()) return {};
  if (!row_exchange_) row_exchange_ = std::make_unique<RowExchange>(scene_, ids_);
  return [this](uint32_t i, std::span<BoundedExchange> later) { row_exchange_->compute(i, later); };
}

uint64_t FaceExchanges::computeChunk(std::span<PairPrior> pairs) {
  std::vector<SidePair> sides;
  std::vector<uint32_t> prior_of_side;  // index in `pairs` of each of `sides`
  for (uint32_t s = 0; s < pairs.size(); ++s) {
    PairPrior& pair = pairs[s];
    if (pair.j >= kEnvironment) {
      pair.exchange = ids_.areas[pair.i];
      continue;
    }
    pair.exchange = 0;
    for (uint32_t p : polygons_[pair.i])
      for (uint32_t q : polygons_[pair.j])
        for (uint32_t side = 0; side < (ids_.two_sided ? 4u : 1u); ++side) {
          sides.push_back({frontSide(p) + side % 2, frontSide(q) + side / 2});
          prior_of_side.push_back(s);
        }
  }
  if (sides.empty()) return 0;
  if (!exchange_)
    exchange_ =
        device_ ? std::make_unique<UnoccludedExchange>(*device_, scene_) : std::make_unique<UnoccludedExchange>(scene_);
  std::vector<double> areas(sides.size());
  const std::vector<UnreachedPair> unreached = exchange_->compute(sides, areas);
  for (size_t k = 0; k < sides.size(); ++k) pairs[prior_of_side[k]].exchange += areas[k] * scene_.scale * scene_.scale;
  uint64_t count = 0;
  for (const UnreachedPair& side : unreached) {
    PairPrior& pair = pairs[prior_of_side[side.pair]];
    count += pair.exchange < INFINITY;
    pair = {pair.i, pair.j, 0, 0, INFINITY};
  }
  return count;
}

}  // namespace viewpeel
