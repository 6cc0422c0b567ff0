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

// A replicate has this number of common directions: directions that all pairs share, for environment and leak.
constexpr uint32_t kLineRunDirections = 32;

// A goal T asks a pair for a standard error of T / kErrorsInGoal, so that the largest error of all pairs is hardly ever
// above T. Environment and leak are sums over many pairs, whose errors have no tails, and there are few of them: fewer
// standard errors do. Measured: docs/accuracy.md.
constexpr double kErrorsInGoal = 4.25, kErrorsInRowGoal = 2.5;

// Gives the pairs of a run lines for its goal: a tolerance, a relative error, or both.
//   In: lines: of ids by face; pairs: as lines.find() has found them; ids: of the result, whose goals are meant;
//   options: goals, replicates, by; most_lines: where the goal takes more, pairs get the lines of a rougher goal that
//   takes about as many
//   Out: the pairs, with lines    Cost: as PairLines::plan.
std::vector<LinePair> planLines(PairLines& lines, std::vector<LinePair> pairs, const Ids& face_ids, const Ids& ids,
                                const EstimateOptions& options, double most_lines);

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
  bool isReached() const { return is_reached_; }
  // Counts one replicate.    Throws: what the engine throws; the sums are then as before.
  void step();
  const RunSums& sums() const { return sums_; }
  // Returns the largest of all pairs so far; infinite before the least number of replicates is done.
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
  // After the planned replicates: how many times its planned lines each pair gets next. Empty where all are done.
  std::vector<uint32_t> further_;
  bool is_reached_ = false;  // all pairs have the lines that their goal asks for
  uint64_t resumed_count_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace viewpeel
