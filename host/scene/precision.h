// How finely a file gives coordinates.
#pragma once
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel {

// What rounding may have moved faces by, input units: a few units in the last place of the largest coordinate, in the
// precision that holds all of them.    Cost: O(corners).
double roundingOf(const InputScene& input);

// The warning about coordinates in single precision so far from the origin that their steps are coarse beside edges;
// empty where there is none to give: at most 1 % of the edges are shorter than 16 steps, or coordinates do not use up
// the steps (whole metres, say), so that precision does not limit them.    Cost: O(corners).
std::string describeCoarseSteps(const InputScene& input);

}  // namespace viewpeel
