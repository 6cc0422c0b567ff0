// FaceExchanges computes unoccluded form factors of pairs of faces.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "unoccluded/row_exchange.h"
#include "unoccluded/unoccluded.h"
#include <viewpeel/ids.h>
#include "sums/visibility_sums.h"

namespace viewpeel {

// A pair gets its unoccluded form factor to the last digit once this many lines hit it; before, it is not worth the
// time.
constexpr uint64_t kLinesToLearn = 32;
// It is the number where there are no rows for other pairs. Of the pairs that isEstimatedByVisibility takes, fewer than
// 1 in 1,000 have fewer lines.
constexpr uint64_t kLinesForVisibility = 16;

struct RunSums;

class FaceExchanges {
 public:
  // Opens nothing yet: kernels are made when they are needed.
  //   In: device: computes them, none: on the processor; ids: by face; all of them are referred to. on_chunk: called
  //     between parts of a fraction of a second, and may throw; may be empty.
  FaceExchanges(const Device* device, const Scene& scene, const Ids& ids, std::function<void()> on_chunk = {});

  // Sets the exchange areas of pairs. They are infinite, with visibilities of 0, where unoccluded form factors are not
  // accurate enough.
  //   Out: how many of the pairs
  //   Error: kUnoccludedRelativeError or kUnoccludedAbsoluteError for each pair of polygons.
  //   Throws: as UnoccludedExchange::compute.
  uint64_t compute(std::span<PairPrior> pairs);

  // Computes unoccluded form factors of the pairs that the run saw and no pilot hit. Where there are rows, it takes the
  // pairs with kLinesToLearn lines. The choice depends on the sums alone.
  void learn(RunSums& sums);

  // Returns the unoccluded form factors of every pair, less accurately (RowExchange). The function is empty where there
  // are more than kMostRowPairs. It refers to this object.
  ExchangeRow rows();

 private:
  bool hasRows() const;
  uint64_t computeChunk(std::span<PairPrior> pairs);

  const Scene& scene_;
  const Ids& ids_;
  const Device* device_;
  std::function<void()> on_chunk_;
  std::vector<std::vector<uint32_t>> polygons_;  // of faces
  // They are made once they are needed.
  std::unique_ptr<UnoccludedExchange> exchange_;
  std::unique_ptr<RowExchange> row_exchange_;
};

}  // namespace viewpeel
