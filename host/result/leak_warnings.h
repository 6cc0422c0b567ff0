// warnOfLeaks() explains results in which lines end on backs.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// A leak of at least this share of the lines of all rows gives a warning. In a closed scene the share is above the
// rounding of edges that touch in part. In an open scene it begins to matter.
constexpr double kClosedLeak = 1e-6, kOpenLeak = 1e-3;

// Returns warnings about leaks, one line each. They state the share of radiation that ends on backs, the surfaces whose
// rows lose it, and the surfaces whose backs get it. Each names the likely cause and the remedy. There is also a
// warning if no front sees another one. The list is empty if nothing is wrong.
//   In: form_factors of the scene, by polygon or by surface
//   Cost: O(entries); above the shares kClosedLeak and kOpenLeak also followFronts.
std::vector<std::string> warnOfLeaks(const Scene& scene, const FormFactors& form_factors);

}  // namespace viewpeel
