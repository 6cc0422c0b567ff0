// warnOfLeaks() explains results in which lines end on backs.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// A leak of more than this share of all rows' lines gives a warning. In a closed scene the share is kClosedLeak: more
// than rounding leaks at edges that touch in part. In an open scene it is kOpenLeak, or less where one row loses more
// than the goal allows it to err.
constexpr double kClosedLeak = 1e-6, kOpenLeak = 1e-3;

// Returns warnings about leaks, one line each. They state the share of radiation that ends on backs, the surfaces that
// lose it, the surfaces whose backs receive it, the likely cause and the remedy. There is also a warning if no front
// sees another front. The list is empty if nothing is wrong.
//   In: form_factors of the scene, by polygon or by surface; goal: the largest error that was asked for; 1: none was
//   Cost: O(entries). Above these shares of leak it also calls followFronts.
std::vector<std::string> warnOfLeaks(const Scene& scene, const FormFactors& form_factors, double goal = 1);

}  // namespace viewpeel
