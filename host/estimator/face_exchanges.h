// FaceExchanges computes the unoccluded form factors of pairs of faces, as exchange areas A_i F_ij.
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

// A pair that this many lines hit gets its unoccluded form factor in double precision. For fewer lines the single
// precision of rows is enough beside the sampling error.
constexpr uint64_t kLinesToLearn = 32;
// This number takes the place of kLinesToLearn where rows() is empty. Of the pairs that isEstimatedByVisibility()
// accepts, fewer than 1 in 1,000 have fewer lines.
constexpr uint64_t kLinesForVisibility = 16;

struct RunSums;

class FaceExchanges {
 public:
  // Computes nothing yet: kernels are compiled when they are needed.
  //   In: device: computes the form factors; nullptr: the processor does; ids: by face. on_chunk: is called several
  //     times a second during a computation, and may throw; may be empty. The caller keeps device, scene and ids alive.
  FaceExchanges(const Device* device, const Scene& scene, const Ids& ids, std::function<void()> on_chunk = {});

  // Sets the exchange area of every pair. Where its unoccluded form factor cannot be computed accurately enough, the
  // pair gets an infinite exchange area and a visibility of 0.
  //   Out: the number of pairs with an infinite exchange area
  //   Error: of each pair of polygons kUnoccludedRelativeError or kUnoccludedAbsoluteError, whichever is larger.
  //   Throws: as UnoccludedExchange::compute.
  uint64_t compute(std::span<PairPrior> pairs);

  // Computes unoccluded form factors of pairs that the run's lines hit and no pilot hit. Where rows() has the other
  // pairs, only pairs with at least kLinesToLearn lines are computed. The choice depends on the sums alone.
  void learn(RunSums& sums);

  // Returns a function that computes the unoccluded form factors of a whole row in single precision (RowExchange). The
  // function is empty where there are more than kMostRowPairs pairs. It must not outlive this object.
  ExchangeRow rows();

 private:
  bool hasRows() const;
  uint64_t computeChunk(std::span<PairPrior> pairs);

  const Scene& scene_;
  const Ids& ids_;
  const Device* device_;
  std::function<void()> on_chunk_;
  std::vector<std::vector<uint32_t>> polygons_;  // of faces
  // Both are nullptr until they are needed.
  std::unique_ptr<UnoccludedExchange> exchange_;
  std::unique_ptr<RowExchange> row_exchange_;
};

}  // namespace viewpeel
