// An OutlineGrid finds the outlines near an edge.
#pragma once
#include <cstdint>
#include <vector>

#include "reference/exact/projection.h"

namespace viewpeel::reference {

// An OutlineGrid is a square grid over the projection; each cell lists the outlines whose bounds touch it.
class OutlineGrid {
 public:
  // The projection must outlive this object. Cost: O(outlines + cells that their bounds cover). The grid has about four
  // cells for each outline.
  explicit OutlineGrid(const Projection& projection);

  // Finds every outline that the edge a -> b meets, and some outlines near the edge. Each is listed once, in any order.
  void findNear(uint32_t a, uint32_t b, std::vector<uint32_t>& outlines);

 private:
  int column(double x) const;
  int row(double y) const;

  const Projection& projection_;
  glm::dvec2 low_{0}, cell_{1};
  int cells_per_side_ = 1;
  std::vector<uint32_t> first_, listed_;
  std::vector<uint32_t> seen_;  // number of the last query that found each outline
  uint32_t query_ = 0;
};

}  // namespace viewpeel::reference
