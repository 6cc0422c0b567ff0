// Sums over replicates of the lines that pairs of faces have of their own, and the exchange areas that follow.
//
// A pair's lines carry weights whose expectation is the unoccluded form factor. The visibility b is the weight of lines
// that nothing blocks over the weight of all lines, a ratio estimator as in share_sums.h. A pair that nothing can block
// has no lines and no error but that of its unoccluded form factor. Derivation: docs/method.md, section 15.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A pair of faces that see each other with nothing in between, and the lines that it gets. Fixed before the first
// replicate. Where lines leak there are pairs of a face and a back, too: j is the number of faces plus the back's face.
struct LinePair {
  uint32_t i, j;           // i < j
  double exchange = 0;     // A_i F_ij with nothing in between, input units squared
  double clear = 0;        // what nothing can block of it
  uint32_t blocks = 0;     // of 16 lines, in a replicate of those planned with lines; 0 where all is clear
  uint32_t period = 1;     // one of so many replicates
  bool by_angles = false;  // how lines are drawn (draw_lines.h)

  bool operator==(const LinePair&) const = default;

  // Returns how many lines are planned for so many replicates.
  double linesIn(uint32_t replicates) const { return 16.0 * blocks * replicates / period; }
  // Whether the pair has lines in a replicate. Pairs take turns.
  bool hasLines(uint64_t replicate) const {
    return blocks && (replicate + i * 0x9E3779B9u + j * 0x85EBCA6Bu) % period == 0;
  }
};

// Returns the entry of the result that a pair of faces, or of a face and a back, is a part of.
std::pair<uint32_t, uint32_t> entryOf(const LinePair& pair, const Ids& face_ids, By by);

// What the lines of a pair came to in one replicate.
struct LineCount {
  uint32_t pair;         // index
  uint32_t blocks;       // of 16 lines that were drawn
  uint32_t facing, all;  // weights of lines that nothing blocks, and of all; kLineUnit for LinePair::blocks
  uint32_t effective;    // number of lines of equal weight that tell as much, in units of 1/256

  bool operator==(const LineCount&) const = default;
};
using LineCounts = std::vector<LineCount>;

constexpr double kLineUnit = 1 << 20;        // the expectation of LineCount::all
constexpr double kMostLineUnits = 1u << 30;  // weights are scaled down to it
constexpr double kEffectiveUnit = 256;
constexpr uint32_t kMostLineBlocks = 1 << 16;  // of a pair in a replicate

class LineSums {
 public:
  // Of one pair. Squares are of counts without their last 4 bits: those of 4,096 replicates are below 2^64.
  struct PairSum {
    uint64_t facing = 0, all = 0, effective = 0;
    uint64_t facing_squares = 0, products = 0, all_squares = 0;  // over replicates
    uint64_t blocks = 0;                                         // of 16 lines
    uint32_t replicates = 0;                                     // with lines

    bool operator==(const PairSum&) const = default;
  };

  //   In: ids by face; by: of the result; pairs sorted by (i, j), every pair at most once
  LineSums(Ids ids, By by, std::vector<LinePair> pairs);
  // Restores sums from a checkpoint.    In: sums: one for each pair
  LineSums(Ids ids, By by, std::vector<LinePair> pairs, std::vector<PairSum> sums, uint64_t replicate_count);

  // Adds one replicate.
  void add(const LineCounts& counts);
  static void addTo(PairSum& sum, const LineCount& count);
  // Adds the sums of other replicates of the same pairs.
  void add(const LineSums& others);

  const Ids& ids() const { return ids_; }
  By by() const { return by_; }
  const std::vector<LinePair>& pairs() const { return pairs_; }
  const std::vector<PairSum>& sums() const { return sums_; }
  uint64_t replicateCount() const { return replicate_count_; }
  // Of all pairs, in all replicates so far.
  uint64_t lineCount() const;

  // Whether a pair is one of a face and a back, and whether any is.
  bool hasBack(size_t pair) const { return pairs_[pair].j >= ids_.count(); }
  bool hasBacks() const;
  // Of the smaller face of a pair, input units squared; of the face where the other is a back.
  double smallerArea(const LinePair& pair) const;
  // Exchange areas of all pairs, and of faces with kLeak as sums over their pairs with backs, sorted; input units
  // squared.
  //   Error: that of replicates and that of independent lines together; see docs/method.md. Coverage:
  //   bench/programs/coverage.cpp.
  std::vector<FormFactors::Entry> entries() const;
  // What entries() says of one pair.
  Measured exchangeArea(size_t pair) const;
  // Whether two runs have the same pairs with the same lines. Unoccluded form factors may differ in rounding.
  bool goesWith(const LineSums& others) const;

 private:
  Ids ids_;
  By by_;
  std::vector<LinePair> pairs_;
  std::vector<PairSum> sums_;
  uint64_t replicate_count_ = 0;
};

// The visibility that lines tell, and its variance.    In: planned_blocks: LinePair::blocks
struct Visibility {
  double value = 0.5, variance = 0.25;
};
Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks);

}  // namespace viewpeel
