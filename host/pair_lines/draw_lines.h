// A LineDrawer draws lines between two patches and finds the lines that nothing blocks.
//
// Lines are drawn in one of three ways:
//   points   from a point of one patch to a point of the other; a line weighs cos cos / (pi r^2) dA dA;
//   angles   from a point of the smaller patch, at a height h over the other's plane. The line ends in this plane, at
//            h tan(a) and h tan(b) from the point's foot, with a and b uniform. This way is for near patches: their
//            weights by points vary without bound, by angles little. Points are denser where the other patch looks
//            larger;
//   contact  from a point of one patch to the same point of the other; for patches of one plane, face to face.
// In all three the share of the weight that nothing blocks is the visibility of the pair (docs/method.md).
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

#include "engines/vectorised.h"
#include "pair_lines/line_ends.h"

namespace viewpeel {

enum class LineWay : uint8_t { points, angles, contact };

// DrawnLines are sums over lines between two patches. Weights have a mean of 1; a line that misses weighs 0.
struct DrawnLines {
  double facing = 0, all = 0;  // weights of lines that nothing blocks, and of all
  double squares = 0;          // of all weights
  uint64_t lines = 0;

  bool operator==(const DrawnLines&) const = default;
};

// Returns what weights are multiplied by, so that their mean is 1.    In: as LineDrawer's
float unitOfWeights(LineWay way, double exchange);

// Returns the direction numbers of Sobol' points in Gray's order, 4 dimensions x 32 bits.
std::span<const uint32_t> sobolBits();

// A LineDrawer is a pair of patches, ready for lines. It is in single precision, about the middle of the smaller patch,
// so that rounding is relative to the distance from there.
class LineDrawer {
 public:
  // Lines are drawn so many at once.
  static constexpr uint32_t kBlockLines = 16;
  // So many blocks, from a multiple of this number on, are added up in single precision.
  static constexpr uint32_t kPortionBlocks = 16;

  //   In: exchange: A F with nothing in between, unit-ball units squared, above 0; all are copied
  LineDrawer(const Patch& a, const Patch& b, LineWay way, double exchange, const std::vector<Blocker>& blockers,
             std::span<const PlacedBlocker> between);

  // Draws lines 16 first to 16 end - 1 of the sequence that the four scrambles make.
  //   Error: rounding of single precision.    Cost: some 4 ns a line and more with every blocker.
  DrawnLines draw(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end, Vectors vectors) const;

 private:
  // A Rectangle is the part of the second patch's plane that angles go to.
  struct Rectangle {
    float axes[2][3];   // of its plane, unit length
    float range[2][2];  // along the axes, least and most
  };
  // A Warp makes uniform numbers in [0, 1) denser in bins with a larger part of the form factor.
  struct Warp {
    static constexpr int kBins = 8;
    float starts[kBins], scales[kBins];  // of bin k: u >= starts[k], and its width over its share
  };
  void frameSecond(const LaneVector<float>* corners, uint32_t count);
  void warpTowards(const LaneVector<float>* corners, uint32_t count, Vectors vectors);
  DrawnLines drawAll(const std::array<uint32_t, 4>& scrambles, uint32_t first, uint32_t end) const;

  LineWay way_;
  LineEnd<float> first_, second_;
  Rectangle rectangle_{};
  Warp warps_[2];  // of points of the first patch, by angles
  float unit_;     // of weights
  std::vector<Obstacle<float>> obstacles_;
};

}  // namespace viewpeel
