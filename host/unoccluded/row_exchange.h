// A RowExchange computes the unoccluded exchange areas of one face with all later faces: many at once, in single
// precision, each with a bound on its error.
//
// It serves pairs with few lines, whose visibility has a larger error. Far pairs are integrated by the product rule of
// 2 points a coordinate. Where one polygon's plane cuts the other polygon, points behind the plane count as 0. Near
// pairs are left to HostUnoccluded.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "unoccluded/host_unoccluded.h"
#include <viewpeel/ids.h>
#include "sums/pair_prior.h"

namespace viewpeel {

class RowExchange {
 public:
  static constexpr size_t kLanes = 4;  // pairs that are computed at once
  using Floats = float __attribute__((vector_size(4 * kLanes)));
  using Flags = int32_t __attribute__((vector_size(4 * kLanes)));  // comparisons set all bits of a number, or none

  //   In: scene: as buildScene makes it; ids: ids of its faces. Neither needs to be kept.
  RowExchange(const Scene& scene, const Ids& ids);

  // Computes the unoccluded exchange areas of id i with ids i + 1, i + 2, ... Several threads may call it at once.
  //   In: later: BoundedExchange[ids - i - 1], each with area 0 and error 0; an error below 0 leaves the id out
  //   Out: later: exchange areas and bounds on their errors, input units squared; 0 and 0 where the two cannot see each
  //     other; ids that are left out are unchanged
  //   Error: within the bounds; tests/unit/row_exchange_test.cpp. A bound exceeds 5 % of its exchange area only where
  //     one polygon is cut by the other's plane.
  //   Cost: O(n) for n ids.
  void compute(uint32_t i, std::span<BoundedExchange> later) const;

 private:
  Flags classify(uint32_t a, size_t start, Floats& errors) const;
  Floats integrate(uint32_t a, size_t start) const;
  void addPolygon(uint32_t a, uint32_t first, std::span<BoundedExchange> later, uint32_t first_id) const;

  HostUnoccluded near_;
  bool two_sided_;
  double unit_;                       // input units squared in one unit-ball unit squared
  std::vector<uint32_t> polygon_;     // indices in Scene::polygons, sorted by id; all arrays below are in this order
  std::vector<uint32_t> id_, plane_;  // id and ShapeData::plane of each polygon
  std::vector<uint32_t> first_;       // the first place of each id's polygons, and at last the number of polygons
  // Coordinates are in single precision, in an array for each axis, unit-ball units.
  std::array<std::vector<float>, 3> middle_, normal_;
  std::array<std::array<std::vector<float>, 3>, 4> points_;  // the four points of the product rule
  std::array<std::vector<float>, 4> weights_;                // their weights, which add up to the polygon's area
  std::vector<float> radius_, reach_, skew_, area_;
  unoccluded_data::FarBound bound_;
};

}  // namespace viewpeel
