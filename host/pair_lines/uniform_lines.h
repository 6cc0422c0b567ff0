// Independent lines that are uniform over all lines between two patches, for bounds that hold beforehand.
//
// A line of density f / F0, f = cos cos / (pi r^2), is blocked or not: a coin whose chance is the visibility. Candidates
// are drawn in the way that wastes fewest, and the rest are rejected, so that the density is f / F0 exactly:
//   points      from a uniform point of one patch to a uniform point of the other, kept with probability f over a bound
//               on f;
//   directions  from a uniform point of the smaller patch along a direction of Lambert's cosine law, kept where it
//               meets the other patch. For patches that are near, where f has no useful bound;
//   contact     a uniform point of the smaller of two patches of one plane, kept where it lies on the other.
// Each decision is made in single precision, again in double precision where rounding might have made it, and is left
// open where even that does not tell. Proof and bounds: docs/method.md, section 14.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "engines/vectorised.h"
#include "pair_lines/line_ends.h"

namespace viewpeel {

struct UniformLineCount {
  uint64_t lines = 0;   // between the two patches
  uint64_t facing = 0;  // that surely nothing blocks
  uint64_t open = 0;    // of which rounding does not tell
  uint64_t candidates = 0;

  UniformLineCount& operator+=(const UniformLineCount& other) {
    lines += other.lines, facing += other.facing, open += other.open, candidates += other.candidates;
    return *this;
  }
};

// Returns a lower bound on the distance of two patches, mostly within some per cent of it; 0 where they touch.
double leastDistance(const Patch& a, const Patch& b);

class UniformLines {
 public:
  //   In: exchange: A F with nothing in between, unit-ball units squared, above 0; between: what may block; all are
  //   copied
  UniformLines(const Patch& a, const Patch& b, double exchange, const std::vector<Blocker>& blockers,
               std::span<const PlacedBlocker> between);

  // Returns the expected share of candidates that are lines of the pair, as its exchange area and the bound on f have
  // it.
  double efficiency() const { return efficiency_; }

  // Draws lines.
  //   In: stream: different ones are independent; lines: wanted
  //   Out: as many lines; where so many candidates fail that the exchange area cannot be true, those missing are open
  //   Cost: some 5 ns a candidate, and as much for every few blockers. Tests: tests/unit/uniform_lines_test.cpp.
  UniformLineCount draw(uint64_t stream, uint64_t lines, Vectors vectors) const;

 private:
  enum class Way : uint8_t { points, directions, contact };
  // All that lines need, in one precision.
  template <class Number>
  struct Geometry {
    LineEnd<Number> first, second;
    std::vector<Obstacle<Number>> obstacles;
    Number axes[3][3];     // of directions: two of the first patch's plane, and its normal
    Number reach;          // longest line, or the length of axes
    Number scale;          // of weights, which are then 1 at most
    Number place_error;    // rounding of places, with that of the random numbers
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
  double most_ = 0;  // of weights
  double efficiency_ = 0;
  Geometry<float> fast_;
  Geometry<double> accurate_;
};

}  // namespace viewpeel
