// A PromiseCost predicts what a whole run costs as a promise, and as an estimate with the same largest error, before
// lines are drawn.
//
// Costs follow from numbers of polygons, pairs and lines alone, so that the same request has the same answer on any
// machine. A run begins with the program and ends with its result. Reading the scene and writing files are left out.
#pragma once
#include <span>

#include "estimator/plan_lines.h"
#include "pair_lines/find_pairs.h"

namespace viewpeel {

// A promise is preferred up to this multiple of the cost of an estimate.
constexpr double kPromiseWorth = 2;
// A promise is also preferred where its whole run takes less than this, in seconds of one thread. A user notices no
// wait below a second (R. B. Miller, Response time in man-computer conversational transactions, 1968), and costs are
// known to a factor of two.
constexpr double kPromiseSeconds = 0.5;

// An estimate draws about this multiple of its planned lines, replicates beyond the plan included.
constexpr double kLinesOverPlan = 1.3;

// A SharedWork is what promise and estimate both do.
struct SharedWork {
  size_t faces = 0;
  double directions = 0;  // common to all pairs, in all replicates
  size_t pairs = 0;       // of faces, found
  FindingWork finding;
};

// EntryLines are the lines of an entry in a promise.
struct EntryLines {
  std::span<const double> exchanges;  // unoccluded, of its parts that something may block
  double smaller_area;                // of its ids, in the same unit
  bool is_pair;                       // whether it is between two ids, or else leak
  double share;                       // estimated share of its lines that nothing blocks
  double lines, candidates, strata;   // expected numbers; strata: lines in strata
  double blockers;                    // of all its parts
};

class PromiseCost {
 public:
  PromiseCost(double tolerance, const SharedWork& shared);
  // Adds an entry.    In: weight: number of entries that it stands for    Cost: O(parts).
  void add(const EntryLines& entry, double weight);
  // Return costs of whole runs in seconds of one thread: of the promise, and of the estimate.
  //   Error: a factor of two; measured in docs/speed.md. Tests: tests/unit/promise_test.cpp.
  double ofPromise() const { return promise_s_; }
  double ofEstimate() const { return estimate_s_; }
  // Returns the part of the promise's cost that follows its plan: lines, and sums over pairs.
  double ofLines() const { return lines_s_; }
  // Returns the cost of finding pairs, a part of either.
  static double ofFinding(const SharedWork& shared);

 private:
  double tolerance_;
  ErrorsInGoal errors_in_goal_;
  double promise_s_, estimate_s_, lines_s_;
};

// Returns whether a run is promised by default.    In: costs as of PromiseCost
constexpr bool isWorthPromise(double promise_s, double estimate_s) {
  return promise_s <= kPromiseWorth * estimate_s || promise_s <= kPromiseSeconds;
}

}  // namespace viewpeel
