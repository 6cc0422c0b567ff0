// rankCoincidentPolygons() gives coincident polygons their tie ranks (Polygon::tie_rank).
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// TieOrders lists pairs of overlapping polygons of one plane, as indices into Scene::polygons.
struct TieOrders {
  // The two look opposite ways, and the first lies below the second along the plane's normal.
  std::vector<std::pair<uint32_t, uint32_t>> below;
  // The two look the same way, and the first has the smaller index.
  std::vector<std::pair<uint32_t, uint32_t>> alike;
};

// Gives every polygon of `orders` a rank. Within a stack of coincident polygons each has the lowest rank that its
// orders allow. All ranks of the stack are then raised by one number, so that the stack is in the middle of all ranks.
//   Of two polygons that look the same way, the orders of `below` decide which one lies in front. Where these leave it
//     open, the polygon of smaller index lies in front. In chains of more than two polygons a greedy colouring, which
//     keeps the number of ranks small, may reverse this.
//   In: scene: its polygons have kContactRank; orders: each pair has polygons of one plane
//   Out: the number of cycles in `below`; each cycle breaks one of its orders. A stack may need more than kTieRanks
//     ranks. If polygons of the stack look the same way, such pairs (`alike`) then have no order. In other stacks that
//     are too high, the highest polygons share the last rank. A warning counts the polygons of both kinds.
//   Tests: tests/unit/alike_test.cpp, tests/unit/coincident_test.cpp
//   Cost: O(n log n) for n pairs.
//   Source: A. Kahn, Topological sorting of large networks, 1962, by layers; greedy colouring in the order of indices.
uint64_t rankCoincidentPolygons(Scene& scene, TieOrders orders);

}  // namespace viewpeel
