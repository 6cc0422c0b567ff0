// A survey of what leaves the scene and what ends on backs, by rays from every polygon. Common directions hardly meet
// the polygons of a scene whose parts are far from each other, such as buildings kilometres apart.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>
#include "rays/ray_engine.h"

namespace viewpeel {

// Shares are of what a row emits, 0 where no row is sure to have one.
struct OutsideShares {
  double largest_environment = 0, largest_leak = 0;
  bool has_outside = false;    // whether more rays leave the scene or end on backs than may have grazed edges
  std::vector<bool> has_leak;  // by id: whether a ray ended on a back
};

// Surveys the requested rows of an engine. A row counts as open, or as leaking, if at least three of its rays leave
// the scene or end on backs. One or two may have grazed an edge within rounding: in nine scenes of 576 to 9,984
// polygons at most 1 ray in 80,000 did so, and no row had three such rays of 1,024. Each row may have few rays through
// a small opening, so the rays of all rows are counted together, too.
//   In: engine: counts by id; rays: of each polygon; further_rays: of each polygon of a row whose rays ended on backs.
//     Both are from usualRays(). The further rays alone decide whether such a row leaks. At most 512 rows get them, the
//     ones that seem to leak most, and at most 2^22 / further_rays
//   Error: with 64 rays a row that leaks 5 % of what it emits is missed with a probability of 0.04. Where more rows
//     leak than get further rays, the largest leak is that of the rows that do
//   Cost: rays x polygons, and the further rays
OutsideShares surveyOutside(RayEngine& engine, const Scene& scene, const Ids& ids, uint32_t rays, uint32_t further_rays,
                            uint64_t seed);

// Returns, by id, whether a ray of the row ends on a back.
//   In: as surveyOutside()
//   Error: a row that leaks the share s of what it emits is missed with the probability (1 - s)^rays
//   Cost: rays x polygons
std::vector<bool> findLeakingRows(RayEngine& engine, const Scene& scene, const Ids& ids, uint32_t rays, uint64_t seed);

}  // namespace viewpeel
