// A HeightOrder decides which of two polygons a line along u meets first.
#pragma once
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <glm/vec2.hpp>

#include "reference/exact/ball.h"
#include "reference/exact/projection.h"

namespace viewpeel::reference {

// Convex polygons that do not pass through one another have one order over the whole overlap of their projections. It
// is decided once per pair, where the heights of their planes differ most. So corners that lie off their plane by
// rounding cannot reverse the order near a shared edge. Where the heights are equal everywhere, the place at ties
// (shaders/facing.h) decides, and then the index.
class HeightOrder {
 public:
  // The projection must outlive this object. Cost: O(outlines).
  explicit HeightOrder(const Projection& projection);

  // Returns true if a comes before b along +u. The answer has a meaning only where the two outlines overlap.
  //   In: a, b: different indices into Projection::outlines
  //   Error: none at the point that is compared. This point lies within rounding of both outlines: 1e-15, and more
  //     beside edges shorter than 1.
  //   Cost: O(corners of a x corners of b) the first time for every pair, then a look-up.
  bool isBelow(uint32_t a, uint32_t b);

 private:
  bool decide(uint32_t a, uint32_t b) const;
  int compareHeights(uint32_t a, uint32_t b, const glm::dvec2& point) const;  // exact sign of height a - height b
  std::vector<glm::dvec2> intersect(uint32_t a, uint32_t b) const;

  // A Height is the height of a plane over the projection: height(x, y) = constant + x_slope x + y_slope y. It is the
  // parameter along u, from the coordinate plane on.
  struct Height {
    Ball constant, x_slope, y_slope;
    Ball at(const glm::dvec2& p) const { return constant + x_slope * Ball{p.x} + y_slope * Ball{p.y}; }
  };
  const Projection& projection_;
  std::vector<Height> heights_;
  std::unordered_map<uint64_t, bool> orders_;
};

}  // namespace viewpeel::reference
