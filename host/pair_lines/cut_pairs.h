// A PairCutter cuts a pair of patches that needs many lines into parts that need fewer lines together.
//
// Of two large patches, most parts are clear of blockers or hidden by one. Clear parts are exact and hidden ones
// exchange nothing. Lines are left for the others. Each of these parts has fewer blockers between its ends than the
// whole pair has. Its points are a stratum of the pair's points.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "pair_lines/find_pairs.h"

namespace viewpeel {

// A CutPart is a part of a pair that is not hidden: two patches, which may be halves of halves, and their blockers.
struct CutPart {
  Patch a, b;
  uint32_t whole_a, whole_b;  // PairFinder::patches from which a and b were cut
  std::vector<PlacedBlocker> between;
};

class PairCutter {
 public:
  //   In: finder: kept by reference
  explicit PairCutter(const PairFinder& finder) : finder_(finder), curtain_(finder.blockers(), finder.mesh()) {}

  // Cuts parts in two, one after the other: always the blocked part that exchanges most, across its larger patch.
  //   In: parts: of one pair; cuts: number of cuts
  //   Out: parts that are not hidden, the same bits for the same input. Parts of two patches of one plane stay whole
  //   Cost: some 2 us a cut and more with every blocker    Tests: tests/unit/cut_pairs_test.cpp.
  std::vector<CutPart> cut(std::vector<CutPart> parts, uint32_t cuts);

 private:
  bool keepBlockers(CutPart& part, std::span<const PlacedBlocker> from);

  const PairFinder& finder_;
  Curtain curtain_;
  BlockerList list_;
  std::vector<uint32_t> between_;
  Vectors vectors_ = widestVectors();
};

}  // namespace viewpeel
