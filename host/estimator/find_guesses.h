// findGuesses() names the pairs whose visibility is a guess, because no line met them.
#pragma once
#include <utility>
#include <vector>

#include <viewpeel/form_factors.h>

#include "sums/run_sums.h"

namespace viewpeel {

// Returns the pairs whose entries are guesses: unoccluded form factors times the visibility of their neighbours.
//   In: sums: of a run; form_factors: made of these sums    Out: pairs (i, j) with i < j, ascending
//   Throws: nothing.    Cost: O(entries).
std::vector<std::pair<uint32_t, uint32_t>> findGuesses(const RunSums& sums, const FormFactors& form_factors);

}  // namespace viewpeel
