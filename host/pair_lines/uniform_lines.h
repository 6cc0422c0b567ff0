// UniformLines draws independent lines, uniform over all lines between two patches. Guarantees are made of them.
//
// Each line has density f / F0, where f = cos cos / (pi r^2) and F0 is its integral over both patches. So the
// probability that nothing blocks it is the visibility.
// Candidates are drawn in the way that wastes fewest, and rejected so that the others have exactly this density:
//   points      from a uniform point of one patch to a uniform point of the other, kept with probability f over a bound
//               on f.
//   directions  from a uniform point of the smaller patch along a direction of Lambert's cosine law, kept where it
//               meets the other patch. This way is for near patches, where f has no useful bound.
//   contact     at a uniform point of the smaller of two patches of one plane, kept where it lies on the other.
// A candidate is decided in double precision where rounding to single precision might change the decision. A line is
// open where double precision cannot tell whether it is blocked. Proof: docs/method.md, section 14.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "pair_lines/line_ends.h"
#include "vectorised.h"

namespace viewpeel {

struct UniformLineCount {
  uint64_t lines = 0;   // between the two patches
  uint64_t facing = 0;  // lines that surely nothing blocks
  uint64_t open = 0;    // lines for which rounding hides whether something blocks them, and lines not drawn
  uint64_t candidates = 0;

  UniformLineCount& operator+=(const UniformLineCount& other) {
    lines += other.lines, facing += other.facing, open += other.open, candidates += other.candidates;
    return *this;
  }
};

template <class Words>
struct Generators;

// StrataSums hold sums over cells with two lines each. A line has x = w (v - s). Here w is its weight over the largest
// weight, v is 1 if nothing blocks it or else 0, and s is a number that the caller chooses.
struct StrataSums {
  uint64_t cells = 0;
  double low = 0, high = 0;                  // sums of x, with open lines taken for blocked, and for facing
  double low_squares = 0, high_squares = 0;  // sums of (x1 - x2)^2 over the two lines of a cell, as low and high
  uint64_t open = 0;                         // lines for which rounding hides whether something blocks them
};

// UniformWay says how candidates are drawn: the three ways at the top of this file.
enum class UniformWay : uint8_t { points, directions, contact };

// Returns a lower bound on the distance of two patches, mostly a few per cent below it; 0 where they touch.
double leastDistance(const Patch& a, const Patch& b);

class UniformLines {
 public:
  //   In: exchange: A F with nothing in between, in units of radius^2, above 0; between: what may block lines. All
  //   arguments are copied
  UniformLines(const Patch& a, const Patch& b, double exchange, const std::vector<Blocker>& blockers,
               std::span<const PlacedBlocker> between);

  // Returns the expected share of candidates that become lines of the pair. It follows from the exchange area and the
  // largest weight.
  double efficiency() const { return efficiency_; }

  // Draws lines.
  //   In: stream: different streams are independent; lines: number of lines
  //   Out: this number of lines; missing ones are open where so many candidates fail that the exchange area is wrong
  //   Cost: some 5 ns a candidate, and as much for every few blockers. Tests: tests/unit/uniform_lines_test.cpp.
  UniformLineCount draw(uint64_t stream, uint64_t lines, Vectors vectors) const;

  // Draws lines in strata: the numbers of a candidate are cut into cells of equal chance. Each cell has two candidates,
  // which are kept with their weights.
  //   In: stream: as for draw(); cells: wanted number; share: s of StrataSums, in [0, 1]
  //   Out: at most a tenth more cells than wanted, at most kMostCells; the mean of x has the expectation efficiency()
  //   times (visibility - share)
  //   Cost: some 10 ns a line. Tests: tests/unit/strata_lines_test.cpp.
  StrataSums drawStrata(uint64_t stream, uint64_t cells, float share, Vectors vectors) const;
  // Returns a bound on the rounding of the mean of x.
  double strataError() const;
  static constexpr uint64_t kMostCells = 1 << 20;  // single precision can number so many cells

 private:
  // A Geometry holds the patches and obstacles in one precision.
  template <class Number>
  struct Geometry {
    LineEnd<Number> first, second;
    std::vector<Obstacle<Number>> obstacles;
    Number disk_low[2], disk_size[2];  // of Disk, along the first two axes
    Number axes[3][3];                 // two axes of the first patch's plane and its normal, each `reach` long
    Number reach;                      // longest line of the pair
    Number scale;                      // factor of weights that makes the largest 1
    Number place_error;                // rounding of places, that of random numbers included
    Number weight_error;               // rounding of weights
    Number least_cosine2;              // square of the cosine below which a direction is not accurate
  };
  template <class Number>
  Geometry<Number> makeGeometry(const Patch& small, const Patch& large, const std::vector<Blocker>& blockers,
                                std::span<const PlacedBlocker> between, bool is_swapped) const;
  void chooseWay(const Patch& small, const Patch& large, double exchange);
  void frameDisk(const Patch& small, const Patch& large, double least_distance);
  void setLengths(const Patch& small, const Patch& large);
  struct Waiting;
  template <class Floats>
  void test(const Waiting& waiting, uint64_t lines, UniformLineCount& sum) const;
  template <class Types>
  UniformLineCount drawAll(uint64_t stream, uint64_t lines) const;
  UniformLineCount decide(const uint32_t* words) const;
  struct XRange;
  struct Cells;
  template <class Floats>
  struct StrataLines;
  Cells cellsOf(uint64_t cells) const;
  template <class Floats, class Words>
  StrataLines<Floats> drawInCells(const Cells& cells, const Floats* at, Generators<Words>& generators,
                                  float share) const;
  XRange decideInCell(const uint32_t* words, const double* at, const Cells& cells, double share) const;
  template <class Types>
  StrataSums drawAllStrata(uint64_t stream, const Cells& cells, float share) const;

  UniformWay way_ = UniformWay::contact;
  double most_ = 0;  // M of docs/method.md, section 14: the largest weight of a candidate, in units of radius^2
  double efficiency_ = 0;
  // A Disk is the rectangle in the unit disk, onto which the hemisphere is projected, that directions are drawn in.
  struct Disk {
    glm::dvec3 axes[2]{};
    float low[2], high[2];
  } disk_{};
  double lengths_[4] = {};  // about how far each number of a candidate moves a line, from 0 to 1, in radii
  Geometry<float> fast_;
  Geometry<double> accurate_;
};

}  // namespace viewpeel
