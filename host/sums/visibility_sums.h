// VisibilitySums adds up facing and blocked lines over replicates, and finds the visibility of each pair from them.
// Derivation: docs/method.md, eq. (14) to (16) and (19) to (22), with the bound on the small bias of a ratio.
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

// Computes the unoccluded exchange areas of id i with every later id, with a bound on each (RowExchange::compute).
// Several threads may call it at once.
using ExchangeRow = std::function<void(uint32_t i, std::span<BoundedExchange> later)>;

// Up to this number of pairs every pair gets an unoccluded form factor, and its neighbours' visibility where no line
// hit it. An entry takes 24 bytes. In larger scenes few runs hit most pairs.
constexpr uint64_t kMostRowPairs = 50'000'000;

class VisibilitySums {
 public:
  __extension__ using Wide = unsigned __int128;
  // A PairSum holds one pair's lines, summed over replicates.
  struct PairSum {
    uint32_t i, j;
    uint64_t facing = 0, blocked = 0;
    std::array<uint64_t, 3> low_squares{};  // squaresOf modulo 2^64, in the order it has
  };
  // Squares holds sums over replicates: facing lines squared, facing times blocked ones, and blocked ones squared.
  struct Squares {
    Wide facing = 0, product = 0, blocked = 0;
  };

  explicit VisibilitySums(Ids ids) : ids_(std::move(ids)) {}
  // Restores sums from a checkpoint.
  //   In: pairs: sorted by (i, j), every pair at most once, without squares; squares: one for each pair
  VisibilitySums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs, const std::vector<Squares>& squares);

  // Adds one replicate.
  //   Throws: Error bad_usage where counts are too large for the sums of squares.    Cost: O(nonzeros).
  void add(const PairCounts& counts);
  // Adds the sums of other replicates.
  void add(const VisibilitySums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  Squares squaresOf(const PairSum& pair) const;
  uint64_t replicateCount() const { return replicate_count_; }

  struct Found {
    std::vector<FormFactors::Entry> entries;
    std::vector<Guess> guesses;  // sorted by entry; without neighbours there are none
  };
  // Estimates the exchange areas of all pairs; calibrateRows then makes guesses fit their rows.
  //   In: prior: pairs with unoccluded exchange areas, sorted by (i, j), every pair at most once
  //   lines: counts that one line adds, by id (lineOf)
  //   measure_area, count_area: as in ReplicateSums
  //   rows: all lines of each row, of the same replicates
  //   sampled: entries of pairs whose counts alone are their estimate
  //   neighbours: of these sums; nullptr: a pair without lines gets the pilot's visibility
  //   row: computes exchange areas of all other pairs; empty: pairs without lines are left out
  //   Error: the bias of a visibility is below its standard error (section 6). With neighbours, a visibility from fewer
  //     than four lines is drawn to its neighbours', which then counts as half a line. Standard errors come from
  //     replicates. They are never less than one line's, nor more than the distance to the farther end of [0, most].
  //     Tests: tests/device/find_prior_test.cpp, bench/programs/coverage.cpp.
  Found find(const std::vector<PairPrior>& prior, const std::vector<uint64_t>& lines, double measure_area,
             double count_area, std::span<const ReplicateSums::Sum> rows,
             const std::vector<FormFactors::Entry>& sampled, const NeighbourVisibility* neighbours = nullptr,
             const ExchangeRow& row = {}) const;

  // Turns the same lines into control variates with visibilities fixed beforehand.    In: visibilities, lines: as in
  // takeControlVariates
  ControlVariateSums controls(const std::vector<PairVisibility>& visibilities,
                              const std::vector<uint64_t>& lines) const;

 private:
  class Entries;
  void addSquares(PairSum& sum, const Squares& squares);

  Ids ids_;
  std::vector<PairSum> pairs_;
  std::map<std::pair<uint32_t, uint32_t>, std::array<uint64_t, 3>>
      high_squares_;  // the upper 64 bits, of pairs with very many lines
  uint64_t replicate_count_ = 0;
};

// Returns the number of independent lines that carry as much information as the lines of a pair. Lines of a replicate
// that come together count as fewer (Kish, Survey Sampling, 1965, section 8.2).
//   In: least: the most counts that one independent line adds
inline double effectiveLines(const VisibilitySums::PairSum& pair, const VisibilitySums::Squares& squares,
                             double least) {
  const double lines = double(pair.facing) + double(pair.blocked),
               of_lines = double(squares.facing) + 2 * double(squares.product) + double(squares.blocked);
  return std::max(lines / least, lines * lines / of_lines);
}

}  // namespace viewpeel
