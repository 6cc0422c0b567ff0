// rankByPlace() orders ids so that ids of about the same place and orientation follow each other.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns the rank of each id: uint32_t[id]. Any 2^k ids whose ranks differ only in the last k bits are near each
// other.
//   The ids are split at the median of the coordinate in which they differ most, and so is each half, down to single
//     ids. An id has six coordinates: its centroid in unit-ball units, and its normal times 2.
//   In: id_of_polygon: the id of each polygon of Scene::polygons, from 0 to count - 1
//   Cost: O(n log^2 n).
std::vector<uint32_t> rankByPlace(const Scene& scene, const std::vector<uint32_t>& id_of_polygon, uint32_t count);

}  // namespace viewpeel
