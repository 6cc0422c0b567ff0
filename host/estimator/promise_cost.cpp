#include "estimator/promise_cost.h"

#include <algorithm>
#include <cmath>

#include "estimator/line_run.h"
#include "pair_lines/pair_lines.h"

namespace viewpeel {
namespace {

// These costs were measured, in seconds of one thread.
constexpr double kFaces = 1e-7, kPair = 1.3e-6;  // to test two faces, and to find what lies between two that face
constexpr double kEstimateLine = 30e-9, kEstimatePart = 4e-6;
constexpr double kPromiseLine = 40e-9, kCandidate = 5e-9, kPromisePart = 4e-6, kStrataLine = 18e-9;
constexpr double kFewLines = 16;  // lines of a part's first pilot; least lines in all its replicates

// Returns the lines that an estimate draws for a part, pilots included (PairLines::plan).
//   In: share: of its lines that nothing blocks; goal: standard error of this share
double estimatedLines(double share, double goal) {
  if (goal >= kCertainError) return kFewLines;
  // Eq. (47) of docs/method.md has the variance 2 b (1 - b) N^-1.25 for one replicate of N lines, that is N / 16
  // blocks, where the share b is known. It is solved for N.
  const double need = std::max(std::pow(2 * share * (1 - share) / (goal * goal), kLineRate), kAgreeingLines / goal);
  return (need > kLinePilots * kFewLines ? kLinePilots * kFewLines : kFewLines) + std::max(need, kFewLines);
}

}  // namespace

PromiseCost::PromiseCost(double tolerance, size_t faces, size_t pairs) : tolerance_(tolerance) {
  promise_s_ = estimate_s_ = kFaces * double(faces) * double(faces) / 2 + kPair * double(pairs);
}

void PromiseCost::add(const EntryLines& entry, double weight) {
  const auto parts = double(entry.exchanges.size());
  const double errors = entry.is_pair ? kErrorsInGoal : kErrorsInRowGoal,
               allowed = tolerance_ * entry.smaller_area / errors;
  // Each part gets its share of the variance by eq. (48) of docs/method.md, which needs the fewest lines.
  const auto partOf = [](double exchange) { return std::pow(exchange, 8.0 / 9); };
  double sum = 0, lines = 0;
  for (const double exchange : entry.exchanges) sum += partOf(exchange);
  for (const double exchange : entry.exchanges)
    lines += estimatedLines(entry.share, allowed * std::sqrt(partOf(exchange) / sum) / exchange);
  estimate_s_ += weight * (lines * kEstimateLine + parts * kEstimatePart);
  promise_s_ += weight * (entry.lines * kPromiseLine + entry.candidates * kCandidate + entry.strata * kStrataLine +
                          parts * kPromisePart);
}

}  // namespace viewpeel
