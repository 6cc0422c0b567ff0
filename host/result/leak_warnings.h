// These warnings are about results whose lines end on backs.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// A leak from this share of the lines of all rows on is worth a warning. In a closed scene it is above the rounding of
// edges that touch in part, in an open one it starts to matter.
constexpr double kClosedLeak = 1e-6, kOpenLeak = 1e-3;

// Warns, one line each, about leaks: the share of radiation that ends on backs, the surfaces whose rows lose it, and
// the surfaces whose backs get it. Each names the likely cause and the remedy. It warns, too, where no front sees
// another one at all. Empty where nothing is wrong.
//   In: form_factors of the scene, by polygon or by surface
//   Cost: O(entries); above the shares kClosedLeak and kOpenLeak also followFronts.
std::vector<std::string> warnOfLeaks(const Scene& scene, const FormFactors& form_factors);

}  // namespace viewpeel
