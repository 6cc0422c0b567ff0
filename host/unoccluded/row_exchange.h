// A RowExchange computes exchange areas of one face with all that follow it, nothing in between: many at once, in
// single precision, each with a bound on its error.
//
// It serves pairs with few lines, whose error is their visibility's. Far pairs take the product rule of 2 points
// a coordinate. Where a plane cuts the other polygon, points behind the plane count as 0. Near pairs are left to
// HostUnoccluded.
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
  // This many pairs are computed at once.
  static constexpr size_t kLanes = 4;
  using Floats = float __attribute__((vector_size(4 * kLanes)));
  using Flags = int32_t __attribute__((vector_size(4 * kLanes)));  // all bits or none

  //   In: ids: by face. Neither is referred to afterwards.
  RowExchange(const Scene& scene, const Ids& ids);

  // May be called by several threads at once.
  //   In: later: one for each of i + 1, i + 2, ...; 0 and 0, or an error below 0: it is not wanted
  //   Out: later: exchange areas with id i, input units squared; 0 and 0 where the two cannot see each other
  //   Error: at most that given: where it is more than 5 % of an exchange area, one polygon is cut by the other's
  //   plane. tests/unit/row_exchange_test.cpp.
  //   Cost: O(n).
  void compute(uint32_t i, std::span<BoundedExchange> later) const;

 private:
  Flags classify(uint32_t a, size_t start, Floats& errors) const;
  Floats integrate(uint32_t a, size_t start) const;
  void addPolygon(uint32_t a, uint32_t first, std::span<BoundedExchange> later, uint32_t first_id) const;

  HostUnoccluded near_;
  bool two_sided_;
  double unit_;                       // input units squared of a unit-ball area
  std::vector<uint32_t> polygon_;     // Scene::polygons, by id
  std::vector<uint32_t> id_, plane_;  // of each polygon, as all that follows
  std::vector<uint32_t> first_;       // of an id among them, and one more
  // Coordinates are in single precision, one array after the other, for all polygons.
  std::array<std::vector<float>, 3> middle_, normal_;
  std::array<std::array<std::vector<float>, 3>, 4> points_;  // of the product rule
  std::array<std::vector<float>, 4> weights_;                // sum: the area
  std::vector<float> radius_, reach_, skew_, area_;
  unoccluded_data::FarBound bound_;
};

}  // namespace viewpeel
