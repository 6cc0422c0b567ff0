// Closed forms of pairs of faces.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "closed_forms/unoccluded.h"
#include "matrix/ids.h"
#include "matrix/known_pair.h"

namespace viewpeel {

class FaceExchanges {
 public:
  //   In: device: on which they are computed, none: on the processor; ids: by face; all of them are referred to
  //     on_chunk: called between parts of a fraction of a second, and may throw; may be empty
  FaceExchanges(const Device* device, const Scene& scene, const Ids& ids, std::function<void()> on_chunk = {});

  // Sets the exchange areas of pairs: infinite, with shares of 0, where closed forms are not accurate enough.    Out: how many of these
  //   Error: kUnoccludedRelativeError or kUnoccludedAbsoluteError for each pair of polygons.
  //   Throws: as UnoccludedExchange::compute.
  uint64_t compute(std::span<KnownPair> pairs);

 private:
  uint64_t computeChunk(std::span<KnownPair> pairs);

  const Scene& scene_;
  const Ids& ids_;
  const Device* device_;
  std::function<void()> on_chunk_;
  std::vector<std::vector<uint32_t>> polygons_;  // of faces
  std::unique_ptr<UnoccludedExchange> exchange_;  // once it is needed
};

}  // namespace viewpeel
