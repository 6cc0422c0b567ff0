// planLines() gives the pairs of a run enough lines for its goal: a tolerance, a relative error, or both; or the root
// mean square of all errors.
#pragma once
#include <vector>

#include "estimator/estimate.h"
#include "pair_lines/pair_lines.h"

namespace viewpeel {

// For a goal T a pair's standard error must be T / kErrorsInGoal, so that the largest error of all pairs is hardly ever
// above T. Measured: docs/accuracy.md.
constexpr double kErrorsInGoal = 4.25;

// Returns how many standard errors of a row's environment or leak must be within the goal. It is the number z beyond
// which one of all rows errs in 1 of 20 runs at most, were all of their errors normal and as large as allowed: errors
// of sums over many pairs are nearly normal.
double errorsInRowGoal(size_t row_count);

// An ErrorsInGoal says how many standard errors of an entry must be within the goal.
class ErrorsInGoal {
 public:
  explicit ErrorsInGoal(size_t row_count) : of_row_(errorsInRowGoal(row_count)) {}
  double of(uint32_t column) const { return column < kEnvironment ? kErrorsInGoal : of_row_; }

 private:
  double of_row_;
};

// Returns the pairs, with lines.
//   In: lines: with ids by face; pairs: from lines.find(); ids: of the result, whose rows the goals are for; options:
//   goals, replicates, by; with_rows: whether all lines of a row must reach the tolerance together; most_lines: where
//   the goal needs more lines than this, pairs get the lines of a rougher goal that needs about this number
//   Cost: as PairLines::plan.
std::vector<LinePair> planLines(PairLines& lines, std::vector<LinePair> pairs, const Ids& face_ids, const Ids& ids,
                                const EstimateOptions& options, bool with_rows, double most_lines);

}  // namespace viewpeel
