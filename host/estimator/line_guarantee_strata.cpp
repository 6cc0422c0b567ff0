// This file decides when an entry of a guarantee gets lines in strata, and how many, and bounds the entry by them:
// docs/method.md, section 14. There M is the largest weight of a candidate, and G the blockable exchange area. A share
// b of the lines meets no blocker, N is a number of lines, and l = ln(1 / p) with p the chance of one bound.
#include <algorithm>
#include <cmath>

#include "estimator/line_guarantee.h"
#include "estimator/strata_bounds.h"

namespace viewpeel {
namespace {

constexpr uint64_t kStrataSeries = 2000;  // series of looks at strata; uniform lines and pilots have smaller numbers
constexpr double kFirstStrata = 4;        // the first look has this times l M / allowed lines (section 14, Strata)
constexpr double kWorthStrata = 0.8;      // strata may take this share of the candidates of uniform lines
constexpr double kVarianceRate = 1.25;    // N lines in strata leave a variance of about N^-1.25
// The variance of N lines is about this times b (1 - b) M G N^-1.25. Most large entries of an office were measured to
// be within a factor of two of it.
constexpr double kVarianceOfStrata = 5.6;
constexpr double kShareOfDeviation = 0.9;       // of the error allowed to an entry: a look is planned for this share
constexpr double kMostStrataLines = 4'000'000;  // most lines of a look at strata
constexpr double kMoreCells = 1.1;              // cells drawn over cells wanted, at most (UniformLines::drawStrata)

}  // namespace

// Returns M of an entry, the sum of the largest weights of its parts, input units squared. Parts left open have none.
double LineGuarantee::sumWeights(const Entry& entry) const {
  double sum = 0;
  for (uint32_t k = 0; k < entry.part_count; ++k)
    if (const Part& part = parts_[entry.first_part + k]; !part.isLeftOpen()) sum += part.largestWeight();
  return sum;
}

// Returns the lines in strata that an entry is expected to need, all looks together.
//   In: share: of its lines that nothing blocks; weights: M, the sum of the largest weights of its parts
double LineGuarantee::expectedStrata(const Entry& entry, double share, double weights) {
  const double l = entry.log_chance, first = kFirstStrata * l * weights / entry.allowed,
               aim = kShareOfDeviation * entry.allowed,
               variance = kVarianceOfStrata * share * (1 - share) * weights * entry.blockable,
               then = std::pow(2 * l * variance / (aim * aim), 1 / kVarianceRate);
  return first + (then > first ? then : 0);
}

// Returns the lines in strata that an entry is expected to need; 0 where uniform lines are likely to take less work.
//   In: share: of its lines that nothing blocks; lines: number of uniform lines that it would need; candidates: mean
//   number of candidates that a uniform line takes
double LineGuarantee::worthStrata(const Entry& entry, double share, double lines, double candidates) {
  if (entry.looks == 1) return 0;
  const double by_strata = expectedStrata(entry, share, entry.blockable * candidates);
  return by_strata < kWorthStrata * lines * candidates && by_strata < kMostStrataLines ? by_strata : 0;
}

// Returns how many lines in strata an entry may draw, all looks together. A look has no more, on average, than there
// are uniform lines up to the last look.
double LineGuarantee::mostStrata(const Entry& entry) const {
  return entry.looks == 1 ? 0 : kStrataLooks * std::min(kMostStrataLines, linesOf(entry, entry.looks - 1));
}

// Decides after the first look at uniform lines whether strata come next.
void LineGuarantee::chooseStrata(Entry& entry) const {
  double facing = 0, lines = 0, candidates = 0;
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    const UniformLineCount& count = parts_[entry.first_part + k].count;
    facing += double(count.facing), lines += double(count.lines), candidates += double(count.candidates);
  }
  const double share = (facing + 1) / (lines + 2);
  if (!(worthStrata(entry, share, expectedLines(entry, share), candidates / lines) > 0)) return;
  entry.strata_lines = kFirstStrata * entry.log_chance * sumWeights(entry) / entry.allowed;
  if (hasRoomForStrata(entry)) entry.strata_looks = kStrataLooks;
}

// Returns whether an entry may draw the lines of its next look at strata.
bool LineGuarantee::hasRoomForStrata(const Entry& entry) const {
  // Each part has at least one cell, of two lines, however few lines it is due.
  const double most = kMoreCells * (entry.strata_lines + 2 * double(entry.part_count));
  return entry.strata_lines <= kMostStrataLines && entry.strata_drawn + most <= mostStrata(entry);
}

// Plans the next look at strata. It gets the least number of lines, in steps of 5 %, for which the squares of the last
// look forecast an error that the entry may have.    In: shown, lines: of the last look
void LineGuarantee::planStrata(Entry& entry, const StrataFigures& shown, double lines) const {
  for (double factor = 1.05; entry.strata_looks > 0; factor *= 1.05) {
    const StrataFigures then{.squares = shown.squares * std::pow(factor, -kVarianceRate),
                             .weight = shown.weight / factor,
                             .cells = shown.cells * factor};
    entry.strata_lines = lines * factor;
    if (!hasRoomForStrata(entry)) entry.strata_looks = 0;
    if (boundDeviation(then, entry.log_chance) <= kShareOfDeviation * entry.allowed) return;
  }
}

// Adds the tasks of all parts for the next look at lines in strata, which are drawn afresh. Parts left open draw none.
void LineGuarantee::addStrataTasks(const Entry& entry, std::vector<StrataTask>& tasks) const {
  const double weights = sumWeights(entry);
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    const Part& part = parts_[entry.first_part + k];
    const double wanted = part.isLeftOpen() ? 0 : entry.strata_lines * part.largestWeight() / weights;
    tasks.push_back({.part = part.index,
                     .share = static_cast<float>(double(part.count.facing) / double(part.count.lines)),
                     .series = kStrataSeries + entry.strata_looks,
                     .cells = part.isLeftOpen() ? 0 : static_cast<uint64_t>(wanted / 2) + 1});
  }
}

// Looks at lines in strata.    In: tasks: of all parts, done    Out: whether the entry is done
bool LineGuarantee::lookAtStrata(Entry& entry, std::span<const StrataTask> tasks) {
  double low = 0, high = 0, guess = 0, rounding = entry.rounding(), lines = 0, drawn_exchange = 0, open_squares = 0;
  StrataFigures low_figures, high_figures;
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    Part& part = parts_[entry.first_part + k];
    if (part.isLeftOpen()) {
      high += part.exchange, guess += part.exchange * double(part.guess.visibility);
      open_squares += std::pow(part.exchange * chanceError(double(part.guess.visibility), double(part.guess.lines)), 2);
      continue;
    }
    const StrataSums& sums = tasks[k].sums;
    const double drawn = 2 * double(sums.cells), largest = part.exchange / tasks[k].efficiency,
                 weight = largest / drawn, expected = part.exchange * double(tasks[k].share);
    low += expected + weight * sums.low, high += expected + weight * sums.high;
    guess += expected + weight * (sums.low + sums.high) / 2;
    rounding += largest * tasks[k].error;
    for (const auto& [figures, squares] :
         {std::pair(&low_figures, sums.low_squares), std::pair(&high_figures, sums.high_squares)}) {
      figures->squares += weight * weight * squares;
      figures->weight = std::max(figures->weight, weight), figures->cells += double(sums.cells);
    }
    part.strata_lines += 2 * sums.cells, lines += drawn, drawn_exchange += part.exchange;
  }
  // However many lines agree, others may not.
  const double least_error = drawn_exchange * chanceError(0, lines);
  const double below = boundDeviation(low_figures, entry.log_chance),
               above = boundDeviation(high_figures, entry.log_chance);
  const bool is_done =
      narrow(entry,
             {std::max(0.0, entry.clear + low - below - rounding),
              entry.clear + std::min(entry.blockable, high + above) + rounding},
             entry.clear + guess, std::sqrt(std::max(high_figures.squares, least_error * least_error) + open_squares));
  --entry.strata_looks, entry.strata_drawn += lines;
  if (!is_done) planStrata(entry, high_figures, lines);
  return is_done;
}

}  // namespace viewpeel
