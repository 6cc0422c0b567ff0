// The environment above the horizon is the sky, and below it the ground.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A SkyShare divides what some polygons send to the environment.
struct SkyShare {
  double sky = 0, ground = 0;  // form factors, whose sum is that to the environment
  double standard_error = 0;   // of both, as far as rays go: of 8 sets of them
};

// Divides the form factor to the environment, e, of polygons that look one way, n being their normal, z up. Without
// anything in the way it would be 1, of which (1 + n_z) / 2 goes up. Of the 1 - e that is blocked rays find the share s
// that would go up:
//   sky = (1 + n_z) / 2 - s (1 - e),  ground = e - sky
//   In: polygons: of each surface that is asked for, in one plane; environment: its e, 0 to 1
//   Out: one for each list, sky and ground from 0 to e
//   Error: the standard error stated, and that of e; none of rays where all that blocks is on one side of the horizon.
//     Rays within 0.6 degrees of the plane are left out: 1e-4 of 1 - e. Tests: tests/files/energyplus_outside_test.cpp.
//   Cost: 65,536 rays a list.
std::vector<SkyShare> divideEnvironment(const Scene& scene, const std::vector<std::vector<uint32_t>>& polygons,
                                        const std::vector<double>& environment);

}  // namespace viewpeel
