// UniformLines::drawStrata, in this file, draws lines in strata.
//
// Candidates keep their weights: rejection by chance would add a variance that no strata reduce. In most cells all
// lines are blocked, or none, so that N lines have a variance of about N^-1.25. The two lines of a cell are
// independent. Half the square of their difference has the expectation of their variance, in any scene (docs/method.md,
// section 14).
#include <algorithm>
#include <cmath>

#include "pair_lines/line_candidates.h"

namespace viewpeel {
namespace {

constexpr uint64_t kPortion = 16;  // number of blocks of sixteen cells that are added up in single precision

}  // namespace

// Cells are the strata of the unit cube of a candidate's four numbers: each number's range is cut into equal parts.
struct UniformLines::Cells {
  uint32_t counts[4] = {1, 1, 1, 1};

  uint64_t count() const { return uint64_t(counts[0]) * counts[1] * counts[2] * counts[3]; }
};

// StrataLines hold x of sixteen lines, one in each of sixteen cells.
template <class Floats>
struct UniformLines::StrataLines {
  Floats low, high;  // with open lines taken for blocked, and for facing
  uint64_t open = 0;
};

// An XRange holds the least and the largest x that rounding leaves possible.
struct UniformLines::XRange {
  double low, high;
};

// Cuts the four numbers so that each moves a line about equally far within a cell.
UniformLines::Cells UniformLines::cellsOf(uint64_t cells) const {
  const double wanted = 1.1 * double(std::min(cells, kMostCells));
  const auto cutInto = [&](double unit) {
    Cells cut;
    for (int d = 0; d < 4; ++d)
      cut.counts[d] = static_cast<uint32_t>(std::clamp(std::round(lengths_[d] / unit), 1.0, double(kMostCells)));
    return cut;
  };
  const auto areTooMany = [&](const Cells& cut) {
    double count = 1;
    for (const uint32_t along : cut.counts) count *= along;
    return count > std::min(wanted, double(kMostCells));
  };
  double coarse = 2 * *std::max_element(lengths_, lengths_ + 4), fine = coarse * 1e-7;
  for (int step = 0; step < 60; ++step) {
    const double middle = std::sqrt(coarse * fine);
    (areTooMany(cutInto(middle)) ? fine : coarse) = middle;
  }
  return cutInto(coarse);
}

double UniformLines::strataError() const {
  // The weights err by weight_error, and sums of kPortion numbers in single precision round, too.
  return double(fast_.weight_error) + 2 * double(kPortion) * 0x1p-24;
}

// Finds x of StrataSums for one line, in double precision.
//   In: words: random numbers; at: place of the cell along the four axes; share: s
UniformLines::XRange UniformLines::decideInCell(const uint32_t* words, const double* at, const Cells& cells,
                                                double share) const {
  double u[kNumbers] = {};
  for (int d = 0; d < 4; ++d) u[d] = (at[d] + withFurtherDigits(words, d)) / cells.counts[d];
  const Candidates<double> line = drawCandidate(way_, accurate_, u);
  if (!(line.inside > 0)) return {0, 0};
  const double weight = std::clamp(line.weight, 0.0, 1.0);
  bool is_open = false;
  for (const Obstacle<double>& obstacle : accurate_.obstacles) {
    double error;
    const double passed = passing(obstacle, accurate_, line, error);
    if (passed < -error) return {-weight * share, -weight * share};
    is_open |= !(passed > error);
  }
  return {weight * ((is_open ? 0 : 1) - share), weight * (1 - share)};
}

// Draws a line in each of sixteen cells.    In: at: places of the cells along the four axes
template <class Floats, class Words>
[[gnu::always_inline]] inline UniformLines::StrataLines<Floats> UniformLines::drawInCells(const Cells& cells,
                                                                                          const Floats* at,
                                                                                          Generators<Words>& generators,
                                                                                          float share) const {
  Words words[kNumbers] = {};
  Floats u[kNumbers] = {};
  for (int d = 0; d < 4; ++d) {
    words[d] = generators.next();
    u[d] = (at[d] + unitNumber(words[d])) * (1.0f / float(cells.counts[d]));
  }
  const Candidates<Floats> line = drawCandidate(way_, fast_, u);
  const Floats one = 1.0f, none{}, is_line = ifBelow(none, line.inside, one, none);
  // A line is blocked if one blocker surely blocks it, and facing if it surely passes all.
  Floats passed = one, blocked = one, worst = line.outside;
  if (isAnyAtMost(none, worst))
    for (size_t k = 0; k < fast_.obstacles.size(); ++k) {
      Floats error;
      const Floats x = passing(fast_.obstacles[k], fast_, line, error);
      passed = least(passed, x - error), blocked = least(blocked, x + error);
      worst = least(worst, blocked);
      if (k % 4 == 3 && !isAnyAtMost(none, worst)) break;
    }
  const Floats is_facing = ifBelow(none, passed, is_line, none), is_blocked = ifBelow(blocked, none, is_line, none),
               is_decided = ifBelow(line.outside, none, one, greatest(is_facing, is_blocked)),
               weight = least(greatest(line.weight, none), one);
  StrataLines<Floats> lines;
  lines.low = lines.high = is_line * weight * (is_facing - share);
  if (!isAnyBelow(is_decided, one)) return lines;
  for (int lane = 0; lane < kLineLanes; ++lane) {
    if (is_decided[lane] > 0) continue;
    uint32_t of_lane[kNumbers] = {};
    double places[4];
    for (int d = 0; d < 4; ++d) of_lane[d] = words[d][lane], places[d] = double(at[d][lane]);
    const XRange x = decideInCell(of_lane, places, cells, double(share));
    lines.low.set(lane, static_cast<float>(x.low)), lines.high.set(lane, static_cast<float>(x.high));
    lines.open += x.high > x.low;
  }
  return lines;
}

template <class Types>
[[gnu::always_inline]] inline StrataSums UniformLines::drawAllStrata(uint64_t stream, const Cells& cells,
                                                                     float share) const {
  using Floats = typename Types::Floats;
  Generators<typename Types::Words> generators(stream);
  const auto all_cells = static_cast<float>(cells.count());
  Floats lanes;
  for (int lane = 0; lane < kLineLanes; ++lane) lanes.set(lane, float(lane));
  StrataSums sums{.cells = cells.count()};
  Floats low{}, high{}, low_squares{}, high_squares{};
  for (uint64_t first = 0, block = 1; first < sums.cells; first += kLineLanes, ++block) {
    // The sixteen cells differ in the first number alone, mostly. So often all lines miss, or all are blocked.
    const Floats cell = lanes + float(first);
    Floats at[4], rest = cell;
    for (int d = 0; d < 3; ++d) {
      const auto along = float(cells.counts[d]);
      const Floats over = (rest + 0.5f) * (1.0f / along);
      const Floats next = wholeOf(over);
      at[d] = rest - next * along, rest = next;
    }
    at[3] = rest;
    const StrataLines<Floats> one = drawInCells(cells, at, generators, share),
                              other = drawInCells(cells, at, generators, share);
    // Lanes beyond the last cell count nothing.
    const Floats exists = all_cells - cell, low_apart = one.low - other.low, high_apart = one.high - other.high;
    low += keep<Floats>(exists, one.low + other.low), high += keep<Floats>(exists, one.high + other.high);
    low_squares += keep<Floats>(exists, low_apart * low_apart),
        high_squares += keep<Floats>(exists, high_apart * high_apart);
    sums.open += one.open + other.open;
    if (block % kPortion != 0 && first + kLineLanes < sums.cells) continue;
    for (int lane = 0; lane < kLineLanes; ++lane) {
      sums.low += double(low[lane]), sums.high += double(high[lane]);
      sums.low_squares += double(low_squares[lane]), sums.high_squares += double(high_squares[lane]);
    }
    low = high = low_squares = high_squares = Floats{};
  }
  return sums;
}

StrataSums UniformLines::drawStrata(uint64_t stream, uint64_t cells, float share, Vectors vectors) const {
  const Cells cut = cellsOf(cells);
  StrataSums sums;
  runInLanes(
      vectors, [&]<class Types>(Types)
                   __attribute__((always_inline)) { sums = drawAllStrata<Types>(stream, cut, share); });
  return sums;
}

}  // namespace viewpeel
