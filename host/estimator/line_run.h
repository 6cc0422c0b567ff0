// A LineRun draws pair lines in steps, one replicate each, until the goal is reached.
//
// Common directions are few here. They tell which rows see the environment and where lines leak; form factors between
// faces come from pair lines (pair_lines.h).
#pragma once
#include <functional>
#include <optional>

#include "estimator/estimate.h"
#include "pair_lines/pair_lines.h"
#include "stopwatch.h"

namespace viewpeel {

// A replicate has so many common directions.
constexpr uint32_t kLineRunDirections = 32;

// A goal T asks a pair for a standard error of T / kErrorsInGoal, so that the largest error of all pairs is hardly ever
// above T. Environment and leak are sums over many pairs, whose errors have no tails, and there are few of them: fewer
// standard errors do. Measured: docs/accuracy.md.
constexpr double kErrorsInGoal = 4.25, kErrorsInRowGoal = 2.5;

// Finds the pairs of a run and gives them lines for its goal: a tolerance, a relative error, or both.
//   In: lines: of ids by face; ids: of the result, whose goals are meant; options: goals, replicates, by; most_lines:
//   where the goal takes more, pairs get the lines of a rougher goal that takes about as many
//   Cost: as PairLines::find and PairLines::plan.
std::vector<LinePair> planLines(PairLines& lines, const Ids& face_ids, const Ids& ids, const EstimateOptions& options,
                                double most_lines);

class LineRun {
 public:
  // Begins, or goes on from options.resumed.
  //   In: engine, face_ids: of common directions; lines: after planLines; pairs: as it has planned, ignored where
  //   options.resumed has them; all but pairs are referred to. options: goals, replicates, first_replicate, seed,
  //   sampler, directions, resumed, by
  LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
          EstimateOptions options);

  // Returns whether the goal is reached, or the next replicate would end after the time.
  bool isDone() const;
  // Returns whether the goal is reached, in time or not.
  bool isReached() const { return !is_any_wanting_; }
  // Counts one replicate.    Throws: what the engine throws; the sums are then as before.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest of all pairs so far; infinite before the least number of replicates is done.
  double largestStandardError() const { return largest_error_; }
  Estimate estimate() const;

 private:
  void measureErrors();
  bool isWanting(const FormFactors::Entry& entry, const Ids& ids) const;

  Engine& engine_;
  PairLines& lines_;
  EstimateOptions options_;
  double count_area_;
  RunSums sums_;
  double largest_error_ = INFINITY;
  std::vector<bool> wanting_;  // of each pair, after the planned replicates: whether it misses the goal
  bool is_any_wanting_ = true;
  uint64_t resumed_count_ = 0;
  Clock::time_point start_ = Clock::now();
  double last_seconds_ = 0;  // of the last replicate
};

}  // namespace viewpeel
