// divideEnvironment() splits form factors to the environment at the horizon: the sky above, the ground below.
#pragma once
#include <cstdint>
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// A SkyShare is the part of a form factor to the environment that goes to the sky, and the part to the ground.
struct SkyShare {
  double sky = 0, ground = 0;  // form factors, whose sum is the one to the environment
  double standard_error = 0;   // of either, by the spread of 8 sets of rays
};

// Splits the form factor e from some polygons to the environment. The polygons look one way, with normal n, and z is
// up. Without obstacles the form factor to the environment would be 1, of which (1 + n_z) / 2 goes up. Obstacles take 1
// - e. Rays find which share s of the blocked radiation goes up:
//   sky = (1 + n_z) / 2 - s (1 - e),  ground = e - sky
//   In: polygons: of each surface, in one plane; environment: e of each surface, 0 to 1
//   Out: by surface, with sky and ground from 0 to e
//   Error: standard_error, and the error of e. Rays add none where all obstacles are on one side of the horizon. Rays
//     within 0.6 degrees of the plane are left out: 1e-4 of 1 - e. Tests: tests/files/energyplus_outside_test.cpp.
//   Cost: 65,536 rays of 2 us for each surface that sees an obstacle, on all threads.
std::vector<SkyShare> divideEnvironment(const Scene& scene, const std::vector<std::vector<uint32_t>>& polygons,
                                        const std::vector<double>& environment);

}  // namespace viewpeel
