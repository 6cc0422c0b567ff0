// Facing and blocked lines of replicates, and what they make of closed forms: the visible share of each.
//
// Of a pair's lines V_r are facing in replicate r, O_r blocked, and E[V_r + O_r] is known: it is the exchange area with
// nothing in between, X_0, in counts. So the exchange area is X = b X_0 with b = sum V_r / sum (V_r + O_r), the ratio
// estimator of survey sampling (Cochran, Sampling Techniques, 1977, chapter 6): what V and V + O have in common
// cancels. Its variance is that of V_r - b (V_r + O_r) = (1 - b) V_r - b O_r. A ratio is biased: by no more than its
// standard error times the relative standard error of sum (V_r + O_r) (Hartley & Ross, Unbiased ratio estimators,
// Nature 174, 1954), and not at all where every line is facing or blocked by chance of its own, however few lines there
// are.
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
#include "sums/known_pair.h"
#include "sums/replicate_sums.h"

namespace viewpeel {

class NeighbourShares;

// Closed forms of an id with each one after it, to the bounds given: no closer than pairs of which few lines tell
// deserve (RowExchange::compute). By several threads at once.
using ExchangeRow = std::function<void(uint32_t i, std::span<BoundedExchange> later)>;

// As many pairs of ids as rows of closed forms are made for, and neighbours looked at: form factors of theirs take 24
// bytes each, and few runs meet most of them where there are more.
constexpr uint64_t kMostRowPairs = 50'000'000;

class ShareSums {
 public:
  __extension__ using Wide = unsigned __int128;
  // Over replicates.
  struct PairSum {
    uint32_t i, j;
    uint64_t facing = 0, blocked = 0;
    std::array<uint64_t, 3> low_squares{};  // squaresOf modulo 2^64, in the order it has
  };
  // Sums of facing lines squared, of facing times blocked ones, and of blocked ones squared.
  struct Squares {
    Wide facing = 0, product = 0, blocked = 0;
  };

  explicit ShareSums(Ids ids) : ids_(std::move(ids)) {}
  // As they were summed before.    In: pairs sorted by (i, j), every pair at most once, without squares; these, one for
  // each
  ShareSums(Ids ids, uint64_t replicate_count, std::vector<PairSum> pairs, const std::vector<Squares>& squares);

  // One replicate.    Throws: Error bad_usage where counts are too large for closed forms.    Cost: O(nonzeros).
  void add(const PairCounts& counts);
  // Other replicates.
  void add(const ShareSums& others);
  const Ids& ids() const { return ids_; }
  const std::vector<PairSum>& pairs() const { return pairs_; }
  Squares squaresOf(const PairSum& pair) const;
  uint64_t replicateCount() const { return replicate_count_; }

  struct Found {
    std::vector<FormFactors::Entry> entries;
    std::vector<Guess> guesses;  // sorted by entry; without neighbours there are none
  };
  // Entries of all pairs, before calibrateRows.
  //   In: known: sorted by (i, j), every pair at most once; lines as in lineOf; measure_area, count_area as in
  //   ReplicateSums; rows: of the same replicates, all lines of each row;
  //     sampled: entries of pairs not known; neighbours: of these sums, nullptr: pairs that no line met have the share
  //     that is known; row: for all other pairs, empty: those that no line met are left out
  //   Error: biased by less than a standard error (above); with neighbours, a share that fewer than four lines tell is
  //   drawn to theirs, of which it is then half a line. Standard errors are those
  //     of replicates, never less than one line's (ControlSums), and no more than the distance to the farther end of
  //     [0, most]; with neighbours, what few lines and theirs say together. A pair that no line met has that of its
  //     neighbours' shares. Tests: tests/device/visible_share_test.cpp, bench/programs/coverage.cpp.
  Found find(const std::vector<KnownPair>& known, const std::vector<uint64_t>& lines, double measure_area,
             double count_area, std::span<const ReplicateSums::Sum> rows,
             const std::vector<FormFactors::Entry>& sampled, const NeighbourShares* neighbours = nullptr,
             const ExchangeRow& row = {}) const;

  // The same lines with shares fixed beforehand.    In: shares, lines as in takeShares
  ControlSums controls(const std::vector<PairShare>& shares, const std::vector<uint64_t>& lines) const;

 private:
  class Entries;
  void addSquares(PairSum& sum, const Squares& squares);

  Ids ids_;
  std::vector<PairSum> pairs_;
  std::map<std::pair<uint32_t, uint32_t>, std::array<uint64_t, 3>>
      high_squares_;  // of those that pass 64 bits: pairs of which very many lines tell
  uint64_t replicate_count_ = 0;
};

// As many lines as tell of a pair: those of a replicate that come as one, or parts of lines, count as the replicates do
// (Kish, Survey Sampling, 1965, section 8.2).
//   In: least: counts that as many lines as told add, at most, each
inline double effectiveLines(const ShareSums::PairSum& pair, const ShareSums::Squares& squares, double least) {
  const double lines = double(pair.facing) + double(pair.blocked),
               of_lines = double(squares.facing) + 2 * double(squares.product) + double(squares.blocked);
  return std::max(lines / least, lines * lines / of_lines);
}

}  // namespace viewpeel
