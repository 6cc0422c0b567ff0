// What is to be said of a result whose lines end on backs.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>
#include <viewpeel/scene.h>

namespace viewpeel {

// Shares of the lines of all rows from which on a leak is worth a warning: in a closed scene above the rounding of
// edges that meet in part, in an open one where it starts to matter.
constexpr double kClosedLeak = 1e-6, kOpenLeak = 1e-3;

// Warnings, one line each: how much of what is emitted ends on backs, which surfaces' rows lose it, onto whose backs,
// the likely cause and what mends it. Also where no front sees another one at all. Empty where nothing is wrong.
//   In: form_factors of the scene, by polygon or by surface
//   Cost: O(entries); above those shares also that of followFronts.
std::vector<std::string> warnOfLeaks(const Scene& scene, const FormFactors& form_factors);

}  // namespace viewpeel
