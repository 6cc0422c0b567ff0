// The ranks are an order in which ids of about the same place and orientation come one after the other.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Ranks ids by place: any 2^k ids whose ranks differ in the last k bits alone are near each other. Ids are halved at
// the median of the coordinate in which they differ most, again and again. The coordinates are their middles in
// unit-ball units, and twice their normals.
//   In: id_of_polygon: of each Scene::polygons entry, 0..count-1
//   Out: the rank of each id.    Cost: O(n log^2 n).
std::vector<uint32_t> rankByPlace(const Scene& scene, const std::vector<uint32_t>& id_of_polygon, uint32_t count);

}  // namespace viewpeel
