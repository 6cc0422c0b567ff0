// A LineRun draws pair lines until the goal is reached, one replicate a step.
//
// It has few common directions, to find which rows see the environment and where lines leak. Form factors between faces
// come from pair lines (pair_lines.h).
#pragma once
#include <functional>
#include <optional>

#include "estimator/estimate.h"
#include "pair_lines/pair_lines.h"
#include "stopwatch.h"

namespace viewpeel {

// A replicate has this number of common directions: directions that all pairs share, for environment and leak.
constexpr uint32_t kLineRunDirections = 32;

// For a goal T a pair's standard error must be T / kErrorsInGoal, so that the largest error of all pairs is hardly ever
// above T. Environment and leak are sums over many pairs: extreme errors are rare, and there are few of them, so fewer
// standard errors suffice. Measured: docs/accuracy.md.
constexpr double kErrorsInGoal = 4.25, kErrorsInRowGoal = 2.5;

// Gives the pairs of a run enough lines for its goal: a tolerance, a relative error, or both.
//   In: lines: with ids by face; pairs: from lines.find(); ids: of the result, for whose rows the goals are; options:
//   goals, replicates, by; most_lines: where the goal needs more, pairs get the lines of a rougher goal that needs
//   about as many
//   Out: the pairs, with lines    Cost: as PairLines::plan.
std::vector<LinePair> planLines(PairLines& lines, std::vector<LinePair> pairs, const Ids& face_ids, const Ids& ids,
                                const EstimateOptions& options, double most_lines);

class LineRun {
 public:
  // Begins a run, or continues options.resumed.
  //   In: engine, face_ids: for common directions; lines: after planLines; pairs: from planLines, ignored with
  //   options.resumed; all but pairs are kept by reference. options: goals, replicates, first_replicate, seed, sampler,
  //   directions, resumed, by
  LineRun(Engine& engine, const Scene& scene, const Ids& face_ids, PairLines& lines, std::vector<LinePair> pairs,
          EstimateOptions options);

  // Returns whether the goal is reached, or the next replicate would end after the time limit.
  bool isDone() const;
  // Returns whether the goal is reached, in time or too late.
  bool isReached() const { return is_reached_; }
  // Counts one replicate.    Throws: as the engine; the sums then stay as they were.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest standard error so far; infinite before the least number of replicates is done.
  double largestStandardError() const { return largest_error_; }
  Estimate estimate() const;

 private:
  void measureErrors();
  std::vector<double> findRowVariances(const FormFactors& all) const;
  void planFurther(const std::vector<std::pair<std::pair<uint32_t, uint32_t>, double>>& wanting);
  double excessOf(const FormFactors::Entry& entry, const Ids& ids) const;
  double furtherLines() const;

  Engine& engine_;
  PairLines& lines_;
  EstimateOptions options_;
  double count_area_;
  RunSums sums_;
  double largest_error_ = INFINITY;
  // By pair: how many times its planned lines it draws in the next replicate. Empty when no pair needs more.
  std::vector<uint32_t> further_;
  bool is_reached_ = false;  // whether all pairs have the lines that their goal needs
  uint64_t resumed_count_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace viewpeel
