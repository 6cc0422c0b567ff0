// findExposedBacks() finds the faces whose backs lines from fronts may meet.
#pragma once
#include <vector>

#include <viewpeel/scene.h>

namespace viewpeel {

// Finds the faces whose backs may be seen from fronts. A back is hidden where its shell is closed, or open only towards
// the outside of the scene, with all fronts on the side where the other faces are. Other backs count as exposed.
//   Error: it misses backs that are seen where shells pass through each other, and backs of a solid that is inside out.
//   Out: bool[Scene::faces]    Cost: as findShells().
std::vector<bool> findExposedBacks(const Scene& scene);

}  // namespace viewpeel
