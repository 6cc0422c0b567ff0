// A promise is compared with an estimate of the same largest error by what they cost, before either draws its lines.
//
// Costs follow from numbers of lines, so that the same request of the same scene gets the same answer on any machine.
// Both find the same pairs first.
#pragma once
#include <span>

namespace viewpeel {

// A promise may cost so many times as much as an estimate and is still preferred to it.
constexpr double kPromiseWorth = 2;

// EntryLines are the lines of an entry, by a promise.
struct EntryLines {
  std::span<const double> exchanges;  // of its parts that something may block, with nothing in between
  double smaller_area;                // of its ids; the same unit
  bool is_pair;                       // whether it is between two ids; else leak
  double share;                       // of its lines that nothing blocks, about
  double lines, candidates;           // expected
};

class PromiseCost {
 public:
  //   In: faces, pairs: how many there are, and how many pairs of them were found
  PromiseCost(double tolerance, size_t faces, size_t pairs);
  // Adds an entry.    In: weight: so many entries like it are meant    Cost: O(parts).
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
