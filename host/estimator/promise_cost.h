// A PromiseCost predicts the costs of a promise and of an estimate with the same largest error, before lines are drawn.
//
// Costs follow from numbers of lines alone, so that the same request has the same answer on any machine. Finding pairs
// costs both the same.
#pragma once
#include <span>

namespace viewpeel {

// A promise is preferred up to this multiple of the cost of an estimate.
constexpr double kPromiseWorth = 2;

// EntryLines are the lines of an entry in a promise.
struct EntryLines {
  std::span<const double> exchanges;  // unoccluded, of its parts that something may block
  double smaller_area;                // of its ids, in the same unit
  bool is_pair;                       // whether it is between two ids, or else leak
  double share;                       // estimated share of its lines that nothing blocks
  double lines, candidates, strata;   // expected numbers; strata: lines in strata
};

class PromiseCost {
 public:
  //   In: faces: number of faces; pairs: number of pairs that were found
  PromiseCost(double tolerance, size_t faces, size_t pairs);
  // Adds an entry.    In: weight: number of entries that it stands for    Cost: O(parts).
  void add(const EntryLines& entry, double weight);
  // Return costs in seconds of one thread: of the promise, and of the estimate.
  //   Error: a factor of two; measured in docs/speed.md. Tests: tests/unit/promise_test.cpp.
  double ofPromise() const { return promise_s_; }
  double ofEstimate() const { return estimate_s_; }

 private:
  double tolerance_;
  double promise_s_ = 0, estimate_s_ = 0;
};

}  // namespace viewpeel
