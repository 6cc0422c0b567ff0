// These functions judge how finely a file gives coordinates.
#pragma once
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns a bound on the distance by which rounding has moved faces, input units. It is a few units in the last place
// of the largest coordinate, in the precision that holds all of them.    Cost: O(corners).
double roundingOf(const InputScene& input);

// Warns about coordinates in single precision so far from the origin that their steps are coarse beside edges.
//   Out: empty where precision does not limit them: at most 1 % of the edges are shorter than 16 steps, or coordinates
//     do not use up the steps (whole metres, say).
//   Cost: O(corners).
std::string describeCoarseSteps(const InputScene& input);

}  // namespace viewpeel
