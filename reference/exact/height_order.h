// Decides which of two polygons a line along u meets first, wherever it meets both.
#pragma once
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <glm/vec2.hpp>

#include "reference/exact/ball.h"
#include "reference/exact/projection.h"

namespace viewpeel::reference {

// Convex polygons that do not pass through one another keep one order over the whole of their common projection. It is
// decided once per pair, where the heights of their planes differ most. So corners that lie off their plane by rounding
// cannot turn it round near a shared edge. Where heights are equal everywhere, place at ties (shaders/facing.h)
// decides, then the index.
class HeightOrder {
 public:
  // Keeps a reference. Cost: O(outlines).
  explicit HeightOrder(const Projection& projection);

  // Returns true where a comes before b along +u. Meaningful where the outlines share area. In: a != b, into
  // Projection::outlines. Error: none at the point looked at, which lies within rounding (1e-15, more beside edges
  // shorter than 1) of both. Cost: O(corners of a x corners of b) once for every pair, then a look-up.
  bool isBelow(uint32_t a, uint32_t b);

 private:
  bool decide(uint32_t a, uint32_t b) const;
  int compareHeights(uint32_t a, uint32_t b, const glm::dvec2& point) const;  // exact sign of height a - height b
  std::vector<glm::dvec2> intersect(uint32_t a, uint32_t b) const;

  // A Height is a function of the place: height(x, y) = constant + x_slope x + y_slope y, the parameter along u from
  // the coordinate plane.
  struct Height {
    Ball constant, x_slope, y_slope;
    Ball at(const glm::dvec2& p) const { return constant + x_slope * Ball{p.x} + y_slope * Ball{p.y}; }
  };
  const Projection& projection_;
  std::vector<Height> heights_;
  std::unordered_map<uint64_t, bool> orders_;
};

}  // namespace viewpeel::reference
