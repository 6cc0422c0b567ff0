// The environment above the horizon is the sky, and below it the ground.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A SkyShare is the part of the radiation from some polygons to the environment that goes up.
struct SkyShare {
  double value = 0;           // 0 to 1; 1/2 where none gets there
  double standard_error = 0;  // of 8 sets of rays
};

// Returns sky / (sky + ground) for polygons that look one way, n being their normal, z up. Let p_up be the share of
// rays above the horizon that get out, and p_down the same below. Then
//   sky = (1 + n_z) / 2 p_up,  ground = (1 - n_z) / 2 p_down
//   In: polygons: of each surface that is asked for, in one plane
//   Out: one for each list
//   Error: the standard error stated; 0 where nothing stands in the way. Rays within 0.6 degrees of the plane are left
//     out: 1e-4. Tests: tests/files/energyplus_outside_test.cpp.
//   Cost: 65,536 rays a list.
//   Source: R. Cranley & T. N. L. Patterson, Randomization of number theoretic methods for multiple integration, SIAM
//     J. Numer. Anal. 13, 1976, 904-914: sequences with random shifts.
std::vector<SkyShare> findSkyShares(const Scene& scene, const std::vector<std::vector<uint32_t>>& polygons);

}  // namespace viewpeel
