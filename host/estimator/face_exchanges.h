// Unoccluded form factors of pairs of faces.
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

constexpr uint64_t kLinesToLearn =
    32;  // of a pair, before its unoccluded form factor to the last digit is worth its time
// The same where there are no rows for other pairs: of those that isEstimatedByVisibility takes, fewer than 1 in 1,000
// have fewer lines.
constexpr uint64_t kLinesForVisibility = 16;

struct RunSums;

class FaceExchanges {
 public:
  //   In: device: on which they are computed, none: on the processor; ids: by face; all of them are referred to
  //     on_chunk: called between parts of a fraction of a second, and may throw; may be empty
  FaceExchanges(const Device* device, const Scene& scene, const Ids& ids, std::function<void()> on_chunk = {});

  // Sets the exchange areas of pairs: infinite, with visibilities of 0, where unoccluded form factors are not accurate
  // enough.    Out: how many of these
  //   Error: kUnoccludedRelativeError or kUnoccludedAbsoluteError for each pair of polygons.
  //   Throws: as UnoccludedExchange::compute.
  uint64_t compute(std::span<PairPrior> pairs);

  // Unoccluded form factors of the pairs that the run saw, which pilots did not meet: where there are rows, of those of
  // which kLinesToLearn told. Which they are depends on the sums alone.
  void learn(RunSums& sums);

  // Of every pair, less accurately (RowExchange); empty where there are more than kMostRowPairs. It refers to this
  // object.
  ExchangeRow rows();

 private:
  bool hasRows() const;
  uint64_t computeChunk(std::span<PairPrior> pairs);

  const Scene& scene_;
  const Ids& ids_;
  const Device* device_;
  std::function<void()> on_chunk_;
  std::vector<std::vector<uint32_t>> polygons_;  // of faces
  // Once they are needed.
  std::unique_ptr<UnoccludedExchange> exchange_;
  std::unique_ptr<RowExchange> row_exchange_;
};

}  // namespace viewpeel
