// These functions judge the precision of the coordinates in a file.
#pragma once
#include <string>

#include <viewpeel/scene.h>

namespace viewpeel {

// Returns a bound on the distance by which rounding has moved corners, input units. It is a few units in the last place
// of the largest coordinate: in single precision where all coordinates are exactly such numbers, else in double
// precision.    Cost: O(corners).
double roundingOf(const InputScene& input);

// Returns a warning where coordinates in single precision lie so far from the origin that the steps between them are
// coarse beside the edges.
//   Out: empty where at most 1 % of the edges are shorter than 16 steps, or where the coordinates are round numbers,
//     such as whole metres, that rounding has not moved
//   Cost: O(corners).
std::string describeCoarseSteps(const InputScene& input);

}  // namespace viewpeel
