// VisibilitySums adds up the facing and blocked lines of each pair over replicates. It estimates the pair's visibility,
// and its exchange area as visibility times unoccluded exchange area. Derivation: docs/method.md, eq. (14) to (16) and
// (19) to (22), with a bound on the small bias of a ratio.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sums/calibrate_rows.h"
#include "sums/pair_prior.h"
#include "sums/replicate_sums.h"

namespace viewpeel {

class NeighbourVisibility;

// An ExchangeRow computes the unoccluded exchange areas of id i with every later id, with a bound on the error of each
// (RowExchange::compute). Several threads may call it at once.
using ExchangeRow = std::function<void(uint32_t i, std::span<BoundedExchange> later)>;

// In scenes of up to this number of pairs, every pair gets an unoccluded form factor, and its neighbours' visibility
// where no line met it. An entry takes 24 bytes. In larger scenes few runs meet most pairs.
constexpr uint64_t kMostRowPairs = 50'000'000;

class VisibilitySums {
 public:
  __extension__ using Wide = unsigned __int128;
  // A PairSum holds one pair's facing and blocked lines, summed over replicates, in counts.
  struct PairSum {
    uint32_t i, j;
    uint64_t facing = 0, blocked = 0;
    std::array<uint64_t, 3> low_squares{};  // the members of Squares, in their order, modulo 2^64
  };
  // A Squares holds sums over replicates of V^2, V O and O^2, with V facing and O blocked lines of a replicate.
  struct Squares {
    Wide facing = 0, product = 0, blocked = 0;
  };

  explicit VisibilitySums(Ids ids) : ids_(std::move(ids)) {}
  // Restores sums from a checkpoint.
  //   In: pairs: sorted by (i, j), every pair at most once, with low_squares 0; squares: Squares[pairs]
  VisibilitySums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs, const std::vector<Squares>& squares);

  // Adds one replicate.
  //   Throws: Error bad_usage where a count exceeds kMostCounts.    Cost: O(pairs).
  void add(const PairCounts& counts);
  // Adds the sums of other replicates.
  void add(const VisibilitySums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  // Returns the sums of squares of one of pairs().
  Squares squaresOf(const PairSum& pair) const;
  uint64_t replicateCount() const { return replicate_count_; }

  // Found holds the estimated entries, and the guessed parts of them.
  struct Found {
    std::vector<FormFactors::Entry> entries;  // sorted by (i, j)
    std::vector<Guess> guesses;               // sorted by entry; empty without neighbours
  };
  // Returns the estimated exchange areas of all pairs, before calibrateRows makes guesses fit their rows.
  //   In: prior: pairs with unoccluded exchange areas, sorted by (i, j), every pair at most once; lines: as in lineOf;
  //     measure_area, count_area: as in ReplicateSums; rows: Sum[ids], sums of all lines of each row in the same
  //     replicates; sampled: entries of the pairs that are estimated by their counts alone, sorted by (i, j);
  //     neighbours: made of these sums; nullptr: a pair that no line met gets the visibility of its prior; row:
  //     computes unoccluded exchange areas of pairs outside the prior; empty: these pairs have no entry unless sampled
  //   Error: the bias of a visibility is below its standard error (section 6). With neighbours, a visibility from fewer
  //     than four lines is averaged with theirs, which count as half a line. Standard errors come from replicates. They
  //     are at least one line's, and at most the distance to the farther end of [0, most].
  //     Tests: tests/device/find_prior_test.cpp, bench/programs/coverage.cpp.
  Found find(const std::vector<PairPrior>& prior, const std::vector<uint64_t>& lines, double measure_area,
             double count_area, std::span<const ReplicateSums::Sum> rows,
             const std::vector<FormFactors::Entry>& sampled, const NeighbourVisibility* neighbours = nullptr,
             const ExchangeRow& row = {}) const;

  // Returns the sums of control variates that takeControlVariates would have made of the same counts.
  //   In: visibilities, lines: as in takeControlVariates
  ControlVariateSums controls(const std::vector<PairVisibility>& visibilities,
                              const std::vector<uint64_t>& lines) const;

 private:
  class Entries;
  void addSquares(PairSum& sum, const Squares& squares);

  Ids ids_;
  std::vector<PairSum> pairs_;
  // Squares / 2^64, by (i, j), of the few pairs that have so many lines that one of the quotients is above 0.
  std::map<std::pair<uint32_t, uint32_t>, std::array<uint64_t, 3>> high_squares_;
  uint64_t replicate_count_ = 0;
};

// Returns the number of independent lines that carry as much information as the lines of a pair. Lines of one replicate
// that meet the pair together count as fewer (Kish, Survey Sampling, 1965, section 8.2).
//   In: least: the most counts that one independent line adds
inline double effectiveLines(const VisibilitySums::PairSum& pair, const VisibilitySums::Squares& squares,
                             double least) {
  const double lines = double(pair.facing) + double(pair.blocked),
               of_lines = double(squares.facing) + 2 * double(squares.product) + double(squares.blocked);
  return std::max(lines / least, lines * lines / of_lines);
}

}  // namespace viewpeel
