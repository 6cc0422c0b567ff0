// LineSums adds up pair lines over replicates and makes exchange areas of the sums.
//
// A pair's lines have weights. Its visibility b is the weight of the lines that nothing blocks over the weight of all
// lines, a ratio estimator as in visibility_sums.h; the exchange area is b times the unoccluded one. A pair that
// nothing can block has no lines, and only the error of its unoccluded form factor. Derivation: docs/method.md, section
// 13.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A LinePair is a pair of faces with an unoccluded form factor above 0, and the number of its lines, which is fixed
// before the first replicate. Where lines leak, a face and the back of another make a pair, too. Its j is the number of
// faces plus the number of the face whose back it is.
struct LinePair {
  uint32_t i, j;           // i < j
  double exchange = 0;     // unoccluded exchange area, input units squared
  double clear = 0;        // the part of `exchange` that nothing can block, input units squared
  double error = 0;        // bound on the error of `exchange`, input units squared
  uint32_t blocks = 0;     // blocks of 16 lines in each replicate in which the pair has lines; 0 where it needs none
  uint32_t period = 1;     // the pair has lines in one of this many replicates
  bool by_angles = false;  // whether lines are drawn by angles, not by points (draw_lines.h)
  uint32_t cuts = 0;       // how many times the pair's parts were cut in two (cut_pairs.h)
  uint32_t parts = 1;      // number of parts that have `blocks` blocks each

  bool operator==(const LinePair&) const = default;

  // Returns how many lines are planned for this number of replicates, on average.
  double linesIn(uint32_t replicates) const { return 16.0 * blocks * parts * replicates / period; }
  // Returns whether the pair has lines in the replicate of this number. Different pairs have lines in different
  // replicates.
  bool hasLines(uint64_t replicate) const {
    return blocks && (replicate + i * 0x9E3779B9u + j * 0x85EBCA6Bu) % period == 0;
  }
};

// Returns the key (i, j) of the entry to which a pair of faces, or of a face and a back, belongs in the result.
//   In: by: whether rows of the result are faces or surfaces
std::pair<uint32_t, uint32_t> entryOf(const LinePair& pair, const Ids& face_ids, By by);

// A LineCount holds the sums of a pair's lines in one replicate.
struct LineCount {
  uint32_t pair;    // index of the pair
  uint32_t blocks;  // blocks of 16 lines that each part drew
  // `facing` is the weight of the lines that nothing blocks, `all` the weight of all lines. The unit is such that `all`
  // is kLineUnit on average for LinePair::blocks blocks.
  uint32_t facing, all;
  // This is the number of independent lines of equal weight that carry as much information, eq. (48a) of
  // docs/method.md, in units of 1/256.
  uint32_t effective;

  bool operator==(const LineCount&) const = default;
};
using LineCounts = std::vector<LineCount>;

// LeakingFaces say from which faces lines may end on backs.
struct LeakingFaces {
  std::vector<bool> of_face;  // by id; empty: from no face
  // This number of rays from each other face ended on no back; 0: there are no other faces, or no rays from them.
  uint32_t rays = 0;
  std::vector<bool> backs{};  // by id, whether lines may end on its back; empty: on all backs

  bool operator==(const LeakingFaces&) const = default;
};

constexpr double kLineUnit = 1 << 20;          // expectation of LineCount::all of LinePair::blocks blocks
constexpr double kMostLineUnits = 1u << 30;    // weights of a replicate are scaled down where they exceed this number
constexpr double kEffectiveUnit = 256;         // LineCount::effective is in units of 1 / 256 lines
constexpr uint32_t kMostLineBlocks = 1 << 16;  // most blocks of a pair in one replicate
constexpr uint32_t kMostCuts = 200'000;        // most cuts of all pairs; each takes some 1.5 kB

// A Visibility is an estimate with its variance. Without lines it is 1/2, with the variance of a number that is 0 or 1.
struct Visibility {
  double value = 0.5, variance = 0.25;
};

class LineSums {
 public:
  // A PairSum holds one pair's sums over replicates. Squares and products are of counts without their last 4 bits, so
  // that the sums of 4,096 replicates stay below 2^64.
  struct PairSum {
    uint64_t facing = 0, all = 0, effective = 0;                 // sums of the members of LineCount
    uint64_t facing_squares = 0, products = 0, all_squares = 0;  // sums of facing^2, facing x all and all^2, over 2^8
    uint64_t blocks = 0;                                         // blocks of 16 lines
    uint32_t replicates = 0;                                     // replicates in which the pair had lines

    bool operator==(const PairSum&) const = default;
  };

  // Makes sums of no replicates.
  //   In: ids: ids of all faces; by: whether rows of the result are faces or surfaces; pairs: sorted by (i, j), every
  //     pair at most once; least_form_factor: pairs with a smaller unoccluded form factor from the smaller face are not
  //     among them; leaking: whose pairs with backs are among them
  LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor = 0, LeakingFaces leaking = {});
  // Restores sums from a checkpoint.    In: sums: PairSum[pairs]
  LineSums(Ids ids, By by, std::vector<LinePair> pairs, double least_form_factor, LeakingFaces leaking,
           const std::vector<PairSum>& sums, uint64_t replicate_count);

  // Adds one replicate.
  void add(const LineCounts& counts);
  // Adds one pair's lines in one replicate to its sums.
  static void addTo(PairSum& sum, const LineCount& count);
  // Adds the sums of other replicates of the same pairs.
  void add(const LineSums& others);

  const Ids& ids() const { return ids_; }
  By by() const { return by_; }
  const std::vector<LinePair>& pairs() const { return pairs_; }
  // Pairs with a smaller unoccluded form factor, from the smaller face, are counted by common directions. With 0 no
  // pair is.
  double leastFormFactor() const { return least_form_factor_; }
  const LeakingFaces& leakingFaces() const { return leaking_; }
  // Returns the sums of the pairs that have lines, in the order of pairs().
  const std::vector<PairSum>& sums() const { return sums_; }
  // Returns the sums of a pair; all are 0 where it has no lines.    In: pair: index in pairs()
  const PairSum& sumOf(size_t pair) const;
  uint64_t replicateCount() const { return replicate_count_; }
  // Returns the number of lines of all pairs in all replicates so far.
  uint64_t lineCount() const;

  // Returns whether a pair is one of a face and a back.
  bool hasBack(size_t pair) const { return pairs_[pair].j >= ids_.count(); }
  // Returns the area of the smaller face of a pair, or of the face in a pair with a back, in input units squared.
  double smallerArea(const LinePair& pair) const;
  // Returns the exchange areas of all pairs of faces, and of each face with kLeak, which is the sum over the face's
  // pairs with backs. They are sorted, and in input units squared.
  //   Error: docs/method.md, eq. (47); bench/programs/coverage.cpp measures how often intervals hold the truth.
  std::vector<FormFactors::Entry> entries() const;
  // By class of pairs: the variance of their lines over the variance that independent lines would have. The classes are
  // by LinePair::blocks.
  using ChanceFactors = std::array<double, 33>;
  ChanceFactors chanceFactors() const;
  // Returns the entry of a pair of faces, or of a face with kLeak. Between faces it has the error that the pair adds to
  // a sum over many pairs: docs/method.md, eq. (61).
  FormFactors::Entry entryAt(size_t pair, const ChanceFactors& factors) const;
  // Returns the exchange areas of entries() by the rows of the result: between faces, or added up between surfaces.
  std::vector<FormFactors::Entry> entriesOfResult() const;
  // Returns the exchange area of one pair, computed as in entries(), in input units squared.
  Measured exchangeArea(size_t pair) const;
  // Returns whether the other sums have the same pairs, with as many lines drawn the same way, so that both can be
  // added. Unoccluded form factors may differ by rounding.
  bool goesWith(const LineSums& others) const;

 private:
  static constexpr uint32_t kNoPlace = UINT32_MAX;

  void findPlaces();
  Measured exchangeArea(size_t pair, const Visibility& visibility) const;
  size_t chunkCount() const;
  void forEachChunk(const std::function<void(size_t chunk, size_t first, size_t end)>& work) const;

  Ids ids_;
  By by_;
  std::vector<LinePair> pairs_;
  double least_form_factor_;
  LeakingFaces leaking_;
  // Most pairs of large scenes have no lines, so sums_ has the others alone. places_ has the index in sums_ of each
  // pair, or kNoPlace.
  std::vector<uint32_t> places_;
  std::vector<PairSum> sums_;
  uint64_t replicate_count_ = 0;
};

// Returns entries between surfaces: sums of the entries between their faces, whose errors are independent.
std::vector<FormFactors::Entry> mergeBySurface(std::vector<FormFactors::Entry> entries,
                                               const std::vector<uint32_t>& surface);

// Adds up entries of one pair of ids, whose errors are independent.    In: entries: sorted by (i, j)
void addSameKeys(std::vector<FormFactors::Entry>& entries);

// Returns the variance of a visibility from so many independent lines of equal weight, eq. (46).
double varianceByChance(double visibility, double lines);
// Returns the visibility of a pair, eq. (44), and its variance, eq. (47).    In: planned_blocks: LinePair::blocks
Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks);

struct LineVariances;
// As above, from variancesOf(sum).    In: sum: with lines
Visibility visibilityOf(const LineSums::PairSum& sum, uint32_t planned_blocks, const LineVariances& of);

// LineVariances are variances of a pair's visibility, from its replicates and by chance: docs/method.md, eq. (47).
struct LineVariances {
  double lines = 0;               // n: lines of equal weight
  double by_chance = 0;           // c: of independent lines
  double expected = 0;            // c D^-1/4: of scrambled points
  double of_replicates = 0;       // s^2; 0 from a single replicate
  double degrees_of_freedom = 0;  // of of_replicates: replicates of one size less 1; 0 from a single replicate
};
// Returns the variances of a pair with lines.
//   In: sum: with lines
LineVariances variancesOf(const LineSums::PairSum& sum);

}  // namespace viewpeel
