// A LineDrawer draws lines between two patches and finds the lines that nothing blocks.
//
// Lines are drawn in one of three ways:
//   points   from a point of one patch to a point of the other; a line of length r weighs cos cos / (pi r^2), with its
//            angles to the two normals;
//   angles between the line and the two normals;
//   angles   from a point of the smaller patch to the other patch's plane, at height h. The line ends at h tan(a) and h
//            tan(b) from the point's foot, with a and b uniform. This way is for near patches: there weights of lines
//            by points vary without bound, and weights of lines by angles vary little. Start points are denser where
//            the other patch looks larger;
//   contact  from a point of one patch to the same point of the other; for patches of one plane, face to face.
// In all three ways the visibility of the pair is the weight of the lines that nothing blocks over the weight of all
// lines (docs/method.md, section 13).
//
// Points are Sobol' points of four dimensions (S. Joe, F. Kuo, Constructing Sobol sequences with better two-dimensional
// projections, SIAM J. Sci. Comput. 30, 2008), scrambled for each replicate apart (A. Owen, Randomly permuted
// (t,m,s)-nets and (t,s)-sequences, 1995). One lattice with random shifts is no substitute: its replicates may all be
// wrong together, for a thin blocker lies between the same points in each of them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pair_lines/line_ends.h"
#include "vectorised.h"

namespace viewpeel {

enum class LineWay : uint8_t { points, angles, contact };

// DrawnLines are sums over lines between two patches. Weights have a mean of 1; a line that misses weighs 0.
struct DrawnLines {
  double facing = 0, all = 0;  // weights of lines that nothing blocks, and of all lines
  double squares = 0;          // sum of the squares of all weights
  uint64_t lines = 0;

  bool operator==(const DrawnLines&) const = default;
};

// Returns the factor of a line's weight that makes the mean weight 1.    In: as LineDrawer's
float unitOfWeights(LineWay way, double exchange);

// A LineDrawer holds a pair of patches, ready to draw lines. Coordinates are in single precision and relative to the
// middle of the smaller patch, so that rounding errors are relative to the distance from there.
class LineDrawer {
 public:
  // This many lines are drawn at once.
  static constexpr uint32_t kBlockLines = 16;
  // This many blocks, from a multiple of this number on, are added up in single precision.
  static constexpr uint32_t kPortionBlocks = 16;

  //   In: exchange: exchange area with nothing in between, unit-ball units squared, above 0; all arguments are copied
  LineDrawer(const Patch& a, const Patch& b, LineWay way, double exchange, const std::vector<Blocker>& blockers,
             std::span<const PlacedBlocker> between);

  // Draws the lines number 16 first to 16 end - 1 of the sequence that the four scrambles define.
  //   Error: rounding of single precision.    Cost: some 4 ns a line and more with every blocker.
  DrawnLines draw(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end, Vectors vectors) const;

 private:
  // A Rectangle surrounds the part of the second patch's plane that lines by angles aim at.
  struct Rectangle {
    float axes[2][3];   // of the second patch's plane, unit length
    float range[2][2];  // least and most coordinate along each axis
  };
  // A Warp makes uniform numbers in [0, 1) denser in bins that hold a larger share of the form factor.
  struct Warp {
    static constexpr int kBins = 8;
    float starts[kBins], scales[kBins];  // of bin k: the least u in it, and its width over its share
  };
  void frameSecond(const LaneVector<float>* corners, uint32_t count);
  void warpTowards(const LaneVector<float>* corners, uint32_t count, Vectors vectors);
  template <class Types>
  DrawnLines drawAll(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end) const;

  LineWay way_;
  LineEnd<float> first_, second_;
  Rectangle rectangle_{};
  Warp warps_[2];  // of points of the first patch, by angles
  float unit_;     // factor of weights
  std::vector<Obstacle<float>> obstacles_;
};

}  // namespace viewpeel
