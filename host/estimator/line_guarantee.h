// A LineGuarantee draws pair lines until every form factor lies in its interval with probability 1 - delta, and every
// form factor between polygons is within epsilon. line_guarantee_plan.cpp plans, line_guarantee.cpp and
// line_guarantee_strata.cpp draw lines, and line_guarantee_result.cpp makes intervals.
//
// An entry of the result has the exchange area clear + share x blockable, and only its share is unknown. Where the
// blockable part is at most epsilon, geometry alone bounds it. Other entries get independent lines (uniform_lines.h).
// Hoeffding's bound gives, before the run, a number of lines that is enough. Chernoff's bound, computed at a few looks,
// each after a set number of lines, may end an entry sooner. An entry that would need many lines gets lines in strata
// first: their own differences bound their variance (strata_bounds.h). Derivation: docs/method.md, section 14.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <viewpeel/result.h>

#include "estimator/strata_bounds.h"
#include "pair_lines/pair_lines.h"
#include "sums/run_sums.h"
#include "vectorised.h"

namespace viewpeel {

// The exchange area that lines give a blockable part has at most this relative error. Its unoccluded exchange area errs
// by kUnoccludedRelativeError, and the density of lines by as much.
constexpr double kRoundingError = 3e-6;

struct LineGuaranteeOptions {
  double epsilon = 1e-2, delta = 1e-2;
  bool rows = false;  // whether each row's environment must be within epsilon, too
  By by = By::polygon;
  // Pairs with a smaller unoccluded form factor than this are not among `pairs`. Common directions count them, and cut
  // their form factors to [0, epsilon]. It is at most epsilon, and 0 by surface.
  double least_form_factor = 0;
  double directions = 0;  // common to all pairs, in all replicates: a part of the predicted cost
};

class LineGuarantee {
 public:
  // Plans which entries need lines, and how many at most. A few lines of each entry predict the expected number.
  //   In: pairs: from lines.find(); ids: of the result; scene, face_ids, ids, lines: kept by reference
  //   Throws: Error bad_usage where epsilon is too small beside rounding.
  //   Cost: O(pairs), and 16 lines of each of 512 entries.
  LineGuarantee(const Scene& scene, const Ids& face_ids, const Ids& ids, PairLines& lines,
                const std::vector<LinePair>& pairs, const LineGuaranteeOptions& options);

  const LineGuaranteeFigures& figures() const { return figures_; }
  // Predicts how long the lines take, and adds these times to figures().
  //   In: finding_seconds: that it took to find the pairs, on the same threads    Error: a factor of about 1.5
  void predictSeconds(double finding_seconds);
  uint64_t lookCount() const { return look_; }
  // Returns the largest number of looks that may be needed.
  uint64_t mostLooks() const { return most_looks_; }
  bool isDone() const { return look_ > 0 && open_.empty(); }
  // Draws the lines of all unfinished entries up to their next look.
  void step();

  // Returns the estimate; once the run is done it has intervals.
  //   In: sums: of common directions, by face, for environment and leak
  Estimate estimate(const RunSums& sums, double relative_floor) const;

 private:
  // An Entry is a form factor between two ids, or the leak of one id. One of the ids may only block (Ids::only_blocks).
  struct Entry {
    uint32_t i, j;
    double error = 0;                 // bound on the error of the sum of the next two
    double clear = 0, blockable = 0;  // unoccluded, of parts that nothing can block and of others; input units squared
    double allowed = 0;               // error of the exchange area that the guarantee allows
    double log_chance = 0;            // ln(1 / p), where p is the chance that one side of one bound fails
    double first_weight = 0;          // largest exchange area that one line stands for, at the first look
    double weight = 0;                // largest exchange area that one line stands for, at the last look
    uint32_t first_part = 0, part_count = 0;
    uint32_t looks = 1, look = 0;             // most looks at uniform lines, and looks done
    uint32_t strata_looks = 0;                // how many looks at lines in strata may still follow
    double strata_lines = 0;                  // lines of the next look at strata
    double strata_drawn = 0;                  // lines of all looks at strata so far
    Interval interval{};                      // of exchange areas
    double first_facing = 0, first_open = 0;  // exchange areas of facing and of open lines of the first look
    double first_variance = 0;                // sum of G_k^2 / n_k over its parts after the first look, eq. (55)
    double most_candidates = INFINITY;        // a line that takes more is left open; where geometry bounds the entry
    double value = 0, standard_error = 0;

    // Returns a bound on what unoccluded form factors and the density of lines add to the error.
    double rounding() const { return error + kRoundingError * blockable; }
    bool isBounded() const { return blockable <= allowed; }
  };
  struct Part {
    uint32_t index;
    double exchange;  // input units squared
    uint32_t blockers;
    VisibilityGuess guess{};  // of open lines
    UniformLineCount count{};
    uint64_t strata_lines = 0;

    // Returns whether all lines are open, mostly because a line would take too many candidates.
    bool isLeftOpen() const { return count.open == count.lines; }
    // Estimates M of docs/method.md, section 14: the largest weight of a candidate, input units squared. The share of
    // candidates that become lines is exchange / M.
    double largestWeight() const { return exchange * double(count.candidates) / double(count.lines); }
  };

  // Tasks are the lines of some entries' next looks.
  struct Tasks {
    std::vector<UniformTask> uniform;
    std::vector<StrataTask> strata;
    std::vector<size_t> first;  // by entry: index of its first part's task in `uniform`, or in `strata`
  };

  // A Row holds sums over the entries of a row, as exchange areas.
  struct Row {
    double lower = 0, upper = 0;              // ends of their intervals
    double first = 0, open = 0, squares = 0;  // clear and facing, open, and first_variance, after the first looks
    double rounding = 0;                      // sum of Entry::rounding()
  };

  std::vector<Row> sumRows() const;
  void requireRows() const;
  void collectEntries(const std::vector<LinePair>& pairs);
  void planLooks();
  static void planEntryLooks(Entry& entry, double chance);
  void planRows();
  void predict();
  UniformLineCount drawPilot(const Entry& entry) const;
  double expectedLines(const Entry& entry, double share) const;
  void planStrata(Entry& entry, const StrataFigures& shown, double lines) const;
  static double expectedStrata(const Entry& entry, double share, double weights);
  static double worthStrata(const Entry& entry, double share, double lines, double candidates);
  double sumWeights(const Entry& entry) const;
  void chooseStrata(Entry& entry) const;
  double mostStrata(const Entry& entry) const;
  bool hasRoomForStrata(const Entry& entry) const;
  void addStrataTasks(const Entry& entry, std::vector<StrataTask>& tasks) const;
  bool lookAtStrata(Entry& entry, std::span<const StrataTask> tasks);
  bool narrow(Entry& entry, const Interval& interval, double value, double standard_error) const;
  void forEach(size_t count, const std::function<void(size_t)>& work) const;
  double weightAt(const Entry& entry, uint32_t look) const;
  double mostCandidates(const Entry& entry, const Part& part) const;
  Tasks tasksOf(std::span<const uint32_t> entries) const;
  void take(Entry& entry, std::span<const UniformTask> tasks);
  // Returns the standard error of a visibility by so many lines. Half a facing and half a blocked line are added, as in
  // docs/method.md, eq. (46).
  static double chanceError(double visibility, double lines);
  bool settle(Entry& entry, uint32_t look) const;
  bool look(Entry& entry, const Tasks& tasks, size_t first);
  // Returns whether an entry serves only the environment: the leak of a row, or what ends on a face that only blocks.
  bool isOutsideResult(const Entry& entry) const {
    return entry.j == kLeak || ids_.onlyBlocks(entry.i) || ids_.onlyBlocks(entry.j);
  }
  std::string nameOf(uint32_t column) const { return column < kEnvironment ? ids_.names[column] : "leak"; }
  double linesOf(const Entry& entry, uint32_t look) const;
  FormFactors withEveryEnvironment(FormFactors all) const;
  std::vector<FormFactors::Entry> countedEntries(const RunSums& sums) const;
  std::vector<Interval> findIntervals(const FormFactors& form_factors) const;

  const Scene& scene_;
  const Ids& face_ids_;
  const Ids& ids_;
  PairLines& lines_;
  LineGuaranteeOptions options_;
  LineGuaranteeFigures figures_;
  std::vector<Entry> entries_;  // sorted by (i, j)
  std::vector<Part> parts_;     // of faces
  size_t pairs_ = 0;            // number of pairs of faces
  double lines_cost_ = 0;       // predicted, of lines and sums: seconds of one thread
  std::vector<uint32_t> open_;  // indices of unfinished entries
  double log_row_ = 0;          // ln(2 / p), where p is the chance that the bound (55) of a row fails
  uint32_t look_ = 0, most_looks_ = 1;
  Vectors vectors_ = widestVectors();

  // In an entry that geometry bounds, lines that would take more candidates than this are left open. These entries are
  // small, such as slivers side by side. The second limit is for entries that matter more, in a row's sum or as a
  // row's leak.
  static constexpr double kMostCandidates = 100, kMostCandidatesOfSums = 10'000;
  static constexpr uint32_t kStrataLooks = 3;   // most looks at lines in strata
  static constexpr double kShareOfOpen = 0.01;  // share of a sum's allowed error that parts left open may take together
};

}  // namespace viewpeel
