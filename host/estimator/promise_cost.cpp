#include "estimator/promise_cost.h"

#include <algorithm>
#include <cmath>

#include "pair_lines/pair_lines.h"

namespace viewpeel {
namespace {

// These costs were measured, in seconds of one thread (docs/speed.md).
constexpr double kStart = 7e-3;                                    // the program's libraries
constexpr double kDirection = 12e-6, kFaceOfDirection = 0.24e-6;   // common directions, on the processor
constexpr double kPair = 0.9e-6, kShaft = 0.3e-6, kTest = 15e-9;   // to find pairs, with closed forms
constexpr double kEstimatePair = 0.4e-6, kPromisePair = 0.7e-6;    // to plan, sum and write down a pair
constexpr double kEstimatePart = 2e-6, kEstimateLine = 18e-9;      // in all replicates
constexpr double kPromisePart = 0.6e-6, kBlockerOfPart = 0.25e-6;  // in all looks
constexpr double kPromiseLine = 20e-9, kCandidate = 5e-9, kStrataLine = 8e-9;
constexpr double kBlockerOfLine = 1e-9, kBlockerOfStrata = 0.6e-9;  // of a line
constexpr double kFewLines = 16;  // lines of a part's first pilot; least lines in all its replicates

// Returns the lines that an estimate draws for a part, pilots included (PairLines::plan).
//   In: share: of its lines that nothing blocks; goal: standard error of this share
double estimatedLines(double share, double goal) {
  if (goal >= kCertainError) return kFewLines;
  // Eq. (47) of docs/method.md has the variance 2 b (1 - b) N^-1.25 where the share b is known. It is that of one
  // replicate of N lines, or N / 16 blocks. It is solved for N.
  const double need = std::max(std::pow(2 * share * (1 - share) / (goal * goal), kLineRate), kAgreeingLines / goal);
  return (need > kLinePilots * kFewLines ? kLinePilots * kFewLines : kFewLines) + std::max(need, kFewLines);
}

}  // namespace

PromiseCost::PromiseCost(double tolerance, const SharedWork& shared)
    : tolerance_(tolerance), errors_in_goal_(shared.faces) {
  const auto pairs = double(shared.pairs);
  const double both =
      kStart + shared.directions * (kDirection + kFaceOfDirection * double(shared.faces)) + ofFinding(shared);
  lines_s_ = kPromisePair * pairs;
  promise_s_ = both + lines_s_;
  estimate_s_ = both + kEstimatePair * pairs;
}

void PromiseCost::add(const EntryLines& entry, double weight) {
  const auto parts = double(entry.exchanges.size());
  const double errors = errors_in_goal_.of(entry.is_pair ? 0 : kLeak),
               allowed = tolerance_ * entry.smaller_area / errors, blocking = kBlockerOfLine * entry.blockers / parts;
  // Each part gets its share of the variance by eq. (48) of docs/method.md, which needs the fewest lines.
  const auto partOf = [](double exchange) { return std::pow(exchange, 8.0 / 9); };
  double sum = 0, lines = 0;
  for (const double exchange : entry.exchanges) sum += partOf(exchange);
  for (const double exchange : entry.exchanges)
    lines += kLinesOverPlan * estimatedLines(entry.share, allowed * std::sqrt(partOf(exchange) / sum) / exchange);
  estimate_s_ += weight * (lines * (kEstimateLine + blocking) + parts * kEstimatePart);
  const double of_lines = weight * (entry.lines * (kPromiseLine + blocking) + entry.candidates * kCandidate +
                                    entry.strata * (kStrataLine + kBlockerOfStrata * entry.blockers / parts) +
                                    parts * kPromisePart + entry.blockers * kBlockerOfPart);
  lines_s_ += of_lines;
  promise_s_ += of_lines;
}

double PromiseCost::ofFinding(const SharedWork& shared) {
  return kPair * double(shared.pairs) + kShaft * double(shared.finding.shafts) + kTest * double(shared.finding.tests);
}

}  // namespace viewpeel
