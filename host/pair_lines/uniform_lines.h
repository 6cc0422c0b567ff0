// UniformLines draws independent lines, uniform over all lines between two patches. Guarantees are made of them.
//
// Each line has density f / F0, f = cos cos / (pi r^2), so it is unblocked with a probability that is the visibility.
// Candidates are drawn in the way that wastes fewest, and rejected so that the others have exactly this density:
//   points      from a uniform point of one patch to a uniform point of the other, kept with probability f over a bound
//               on f;
//   directions  from a uniform point of the smaller patch along a direction of Lambert's cosine law, kept where it
//               meets the other patch. This way is for near patches, where f has no useful bound;
//   contact     at a uniform point of the smaller of two patches of one plane, kept where it lies on the other.
// A candidate is decided in double precision where rounding to single precision might change the decision. A line is
// open where double precision cannot tell whether it is blocked. Proof: docs/method.md, section 14.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "engines/vectorised.h"
#include "pair_lines/line_ends.h"

namespace viewpeel {

struct UniformLineCount {
  uint64_t lines = 0;   // between the two patches
  uint64_t facing = 0;  // lines that surely nothing blocks
  uint64_t open = 0;    // lines of which rounding hides whether something blocks them
  uint64_t candidates = 0;

  UniformLineCount& operator+=(const UniformLineCount& other) {
    lines += other.lines, facing += other.facing, open += other.open, candidates += other.candidates;
    return *this;
  }
};

// Returns a lower bound on the distance of two patches, mostly a few per cent below it; 0 where they touch.
double leastDistance(const Patch& a, const Patch& b);

class UniformLines {
 public:
  //   In: exchange: A F with nothing in between, in units of radius^2, above 0; between: what may block lines. All
  //   arguments are copied
  UniformLines(const Patch& a, const Patch& b, double exchange, const std::vector<Blocker>& blockers,
               std::span<const PlacedBlocker> between);

  // Returns the expected share of candidates that become lines of the pair, by its exchange area and the bound on
  // f.
  double efficiency() const { return efficiency_; }

  // Draws lines.
  //   In: stream: different streams are independent; lines: number of lines
  //   Out: this number of lines; missing ones are open where so many candidates fail that the exchange area is wrong
  //   Cost: some 5 ns a candidate, and as much for every few blockers. Tests: tests/unit/uniform_lines_test.cpp.
  UniformLineCount draw(uint64_t stream, uint64_t lines, Vectors vectors) const;

 private:
  enum class Way : uint8_t { points, directions, contact };
  // A Geometry holds the patches and obstacles in one precision.
  template <class Number>
  struct Geometry {
    LineEnd<Number> first, second;
    std::vector<Obstacle<Number>> obstacles;
    Number axes[3][3];     // two axes of the first patch's plane and its normal, each `reach` long
    Number reach;          // longest line of the pair
    Number scale;          // factor of weights that makes the largest 1
    Number place_error;    // rounding of places, that of random numbers included
    Number weight_error;   // rounding of weights
    Number least_cosine2;  // square of the cosine below which a direction is not accurate
  };
  template <class Number>
  Geometry<Number> makeGeometry(const Patch& small, const Patch& large, const std::vector<Blocker>& blockers,
                                std::span<const PlacedBlocker> between, bool is_swapped) const;
  void chooseWay(const Patch& small, const Patch& large, double exchange);
  struct Waiting;
  void test(const Waiting& waiting, uint64_t lines, UniformLineCount& sum) const;
  UniformLineCount drawAll(uint64_t stream, uint64_t lines) const;
  UniformLineCount decide(const uint32_t* words) const;

  Way way_ = Way::contact;
  double most_ = 0;  // largest weight
  double efficiency_ = 0;
  Geometry<float> fast_;
  Geometry<double> accurate_;
};

}  // namespace viewpeel
