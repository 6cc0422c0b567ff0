// Tie ranks are places of coincident polygons along the normal of their plane (Polygon::tie_rank).
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// TieOrders are orders of polygons of one plane that overlap, by indices of Scene::polygons.
struct TieOrders {
  std::vector<std::pair<uint32_t, uint32_t>> below;  // look opposite ways; the first is lower along the plane's normal
  std::vector<std::pair<uint32_t, uint32_t>> alike;  // look the same way; the first has the smaller index
};

// Gives every polygon of `orders` the lowest place that its orders leave it. The places of a stack of coincident
// polygons lie in the middle of the ranks.
//   Of two that look alike the orders of `below` decide which one lies in front, along their own normal. Where they
//     leave it open the one of smaller index lies in front. In chains of more than two a greedy colouring, which keeps
//     the ranks few, may put the other one in front.
//   In: scene whose polygons have kContactRank; of each pair of `orders`, polygons of one plane
//   Out: tie ranks; the number of cycles in `below`, each of which breaks one of its orders. Where stacks with pairs of
//     `alike` need more than kTieRanks places, these pairs have no order. Polygons of higher stacks have the last rank.
//     A warning counts the polygons of both.
//   Throws: nothing.
//   Tests: tests/unit/alike_test.cpp, tests/unit/coincident_test.cpp
//   Cost: O(n log n) for n pairs.
//   Source: A. Kahn, Topological sorting of large networks, 1962, by layers; greedy colouring in the order of indices.
uint64_t rankCoincidentPolygons(Scene& scene, TieOrders orders);

}  // namespace viewpeel
